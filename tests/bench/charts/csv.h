// The rows of the study of speed against accuracy as CSV.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/result.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// All columns, in order; docs/data/README.md describes each.
std::span<const std::string_view> chart_columns();

/// A line of names, then one line a row; a missing value stays empty. Error: kInternal: a row has a
/// key that is no column.
Result<std::string> chart_csv(const std::vector<Row>& rows);

}  // namespace sightline::bench
