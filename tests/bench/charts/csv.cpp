// The rows of the study of speed against accuracy as CSV.
#include "tests/bench/charts/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace sightline::bench {
namespace {

constexpr std::array<std::string_view, 43> kColumns{
    // What was measured.
    "study", "scene", "triangles", "builder", "configuration", "line", "value", "usual", "policy",
    "rays", "count", "rounds", "basis",
    // study = build
    "build_ms", "build_ms_min", "mtris_per_s", "sah_cost", "nodes", "references", "max_depth",
    "overlap", "bytes", "touches",
    // study = trace
    "steps_per_ray", "tests_per_ray", "work_per_ray", "work_over_sweep", "trace_ms", "trace_ms_min",
    "trace_over_sweep", "mrays_per_s", "hit_hash", "unexplained",
    // study = image
    "seconds_to_hits", "seconds_to_hits_min",
    // The same values in every row.
    "threads", "repeat", "seed", "rotate", "machine", "compiler", "commit", "date"};

// Texts with a comma or a quotation mark are quoted.
std::string field(const Row& value) {
  if (value.is_null()) return "";
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_string()) return value.dump();
  const auto text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::span<const std::string_view> chart_columns() { return kColumns; }

Result<std::string> chart_csv(const std::vector<Row>& rows) {
  std::string text = fmt::format("{}\n", fmt::join(kColumns, ","));
  for (const Row& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(kColumns.begin(), kColumns.end(), key) == kColumns.end()) {
        return Error{Code::kInternal, fmt::format("no column {} in the CSV", key), "NO_COLUMN"};
      }
    }
    std::string line;
    for (const std::string_view column : kColumns) {
      if (column != kColumns.front()) line += ',';
      if (const auto found = row.find(column); found != row.end()) line += field(*found);
    }
    text += line + '\n';
  }
  return text;
}

}  // namespace sightline::bench
