// What sections have in common.
#include "client/load/report/section.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline::client::load::report {

std::string label_of(const Row& row, const LoadOptions& options) {
  std::string label = row.build == BuildMode::kServerPolicy ? "warm" : name_of(row.build);
  if (options.coverage.size() > 1) label += fmt::format(" {} %", row.coverage);
  return label;
}

int colour_of(BuildMode build) {
  switch (build) {
    case BuildMode::kFull:
      return 1;
    case BuildMode::kNone:
      return 2;
    default:
      return 0;
  }
}

std::string words_of(BuildMode build) {
  switch (build) {
    case BuildMode::kLazy:
      return "building on demand (lazy)";
    case BuildMode::kFull:
      return "building everything first (full)";
    case BuildMode::kNone:
      return "building nothing (none)";
    default:
      return "the server's policy";
  }
}

std::vector<double> extreme_coverages(const LoadOptions& options) {
  const auto [low, high] = std::minmax_element(options.coverage.begin(), options.coverage.end());
  return low == high ? std::vector{*low} : std::vector{*low, *high};
}

std::vector<const Row*> rows_at(const Findings& findings, double coverage) {
  std::vector<const Row*> rows;
  for (const Row& row : findings.result.rows) {
    if (row.coverage == coverage && row.run.record.rays > 0) rows.push_back(&row);
  }
  return rows;
}

std::vector<const Row*> widest_rows(const Findings& findings) {
  return rows_at(findings, extreme_coverages(findings.options).back());
}

}  // namespace sightline::client::load::report
