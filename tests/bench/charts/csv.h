// The rows of the study of speed against accuracy as CSV.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accel/result.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// Every column there is, in order; docs/data/README.md says what each holds.
std::span<const std::string_view> chart_columns();

/// A line of names, then a line a row; what a row does not have stays empty. Error: kInternal, a
/// row with a key that is no column.
Result<std::string> chart_csv(const std::vector<Row>& rows);

}  // namespace sightline::bench
