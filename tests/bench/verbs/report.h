// Rows of named figures, as JSON lines or as a table for people.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sightline::bench {

/// Keys keep the order in which they were set.
using Row = nlohmann::ordered_json;

/// One JSON object a line.
std::string to_json_lines(const std::vector<Row>& rows);

/// An aligned table with keys in the order of their first appearance: one line a key and one column
/// a row, or transposed if there are more than kMostColumns rows.
inline constexpr std::size_t kMostColumns = 16;
std::string to_table(const std::vector<Row>& rows);

/// The middle value, or the mean of the two middle ones. `values` is not empty.
double median(std::vector<double> values);

/// The quantile at `share`: 0 is the least value, 1 the largest, linear in between. `values` is not
/// empty.
double quantile(std::vector<double> values, double share);

/// Sets key to the median and key_min to the least.
void set_times(Row& row, const std::string& key, const std::vector<double>& values);

}  // namespace sightline::bench
