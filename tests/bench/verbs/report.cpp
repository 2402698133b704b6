// Rows of named figures.
#include "tests/bench/verbs/report.h"

#include <fmt/core.h>

#include <algorithm>

namespace sightline::bench {
namespace {

std::string cell_text(const Row& row, const std::string& key) {
  const auto found = row.find(key);
  if (found == row.end() || found->is_null()) return "-";
  if (found->is_string()) return found->get<std::string>();
  if (found->is_number_float()) return fmt::format("{:.6g}", found->get<double>());
  return found->dump();
}

std::vector<std::string> all_keys(const std::vector<Row>& rows) {
  std::vector<std::string> keys;
  for (const Row& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  return keys;
}

using Lines = std::vector<std::vector<std::string>>;

Lines transposed(const Lines& lines) {
  Lines result;
  for (std::size_t i = 0; !lines.empty() && i < lines.front().size(); ++i) {
    result.emplace_back();
    for (const auto& line : lines) result.back().push_back(line[i]);
  }
  return result;
}

// The first column is left-aligned, the others are right-aligned.
std::string aligned(const Lines& lines) {
  std::vector<std::size_t> widths;
  for (const auto& line : lines) {
    widths.resize(line.size());
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      text += i == 0 ? fmt::format("{:<{}}", line[i], widths[i])
                     : fmt::format("  {:>{}}", line[i], widths[i]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

std::string to_json_lines(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) text += row.dump() + "\n";
  return text;
}

std::string to_table(const std::vector<Row>& rows) {
  const std::vector<std::string> keys = all_keys(rows);
  Lines lines;
  for (const std::string& key : keys) {
    lines.push_back({key});
    for (const Row& row : rows) lines.back().push_back(cell_text(row, key));
  }
  return aligned(rows.size() > kMostColumns ? transposed(lines) : lines);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (values[above] - values[below]) * (at - static_cast<double>(below));
}

void set_times(Row& row, const std::string& key, const std::vector<double>& values) {
  row[key] = median(values);
  row[key + "_min"] = *std::min_element(values.begin(), values.end());
}

}  // namespace sightline::bench
