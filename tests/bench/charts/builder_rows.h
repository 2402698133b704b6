// What was measured of a builder, and the rows that say so.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "accel/kdtree/tree_metrics.h"
#include "tests/bench/charts/configurations.h"
#include "tests/bench/charts/scenes.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// The kinds of rays that every builder's trees answer.
inline constexpr std::array<std::string_view, 3> kChartRays{"overview", "diffuse", "random"};

/// A work of one: an inner node visited. A triangle test counts as much as it does in sah_cost.
inline constexpr double kChartTestWork = accel::kdtree::kMeasuredIntersect;

struct ChartTraced {
  std::vector<double> trace_ms;  ///< One a round.
  std::uint64_t steps = 0, tests = 0;
  std::string hash;
  std::optional<std::uint64_t> unexplained;  ///< Embree's alone.
};

struct ChartMeasured {
  std::vector<double> build_ms;  ///< One a round, or one for all.
  std::uint64_t touches = 0;
  std::optional<accel::kdtree::TreeMetrics> metrics;  ///< Ours alone.
  std::uint64_t bytes = 0;                            ///< Embree's alone: ours are in the metrics.
  std::array<ChartTraced, kChartRays.size()> by_rays;
};

/// The rows of study = build, then those of study = trace; measured[i] is of contenders[i], with
/// `rays` rays of each kind.
std::vector<Row> chart_builder_rows(const ChartScene& scene,
                                    const std::vector<ChartContender>& contenders,
                                    const std::vector<ChartMeasured>& measured, std::size_t rays);

}  // namespace sightline::bench
