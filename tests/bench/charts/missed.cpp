// Rays that methods lose on closed scenes, against how fast they are.
#include "tests/bench/charts/missed.h"

#include <algorithm>
#include <array>

#include "accel/published/any_builder.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

constexpr std::array<std::string_view, 4> kBuilders{"scan-fast", "scan-best", "bvh-binned", "sbvh"};

}  // namespace

Result<std::vector<Row>> chart_missed(const CommonOptions& common, const ChartPlan& plan) {
  RobustOptions options;
  options.level = plan.sphere_level;
  options.count = plan.aimed_rays;
  const auto known = accel::published::builder_names();
  for (const std::string_view name : kBuilders) {
    if (std::find(known.begin(), known.end(), name) != known.end()) {
      options.builders.emplace_back(name);
    }
  }
  auto found = run_robust(common, options);
  if (!found.ok()) return found.error();
  std::vector<Row> rows;
  for (Row& row : *found) {
    Row renamed;
    renamed["study"] = "missed";
    renamed["configuration"] = row["builder"];
    for (auto& [key, value] : row.items()) {
      const char* name = key == "family" ? "scene" : nullptr;
      if (key == "kind") name = "rays";
      if (key == "rays") name = "count";
      renamed[name == nullptr ? key : name] = std::move(value);
    }
    rows.push_back(std::move(renamed));
  }
  return rows;
}

}  // namespace sightline::bench
