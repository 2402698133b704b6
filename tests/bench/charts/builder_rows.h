// What is measured of a builder, and the rows that report it.
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

/// The kinds of rays traced through every builder's trees.
inline constexpr std::array<std::string_view, 3> kChartRays{"overview", "diffuse", "random"};

/// The unit of work: one inner node visited. A triangle test counts as much as it does in sah_cost.
inline constexpr double kChartTestWork = accel::kdtree::kMeasuredIntersect;

struct ChartTraced {
  std::vector<double> trace_ms;  ///< One value a round.
  std::uint64_t steps = 0, tests = 0;
  std::string hash;
  std::optional<std::uint64_t> unexplained;  ///< Embree only.
};

struct ChartMeasured {
  std::vector<double> build_ms;  ///< One value a round, or one for all rounds.
  std::uint64_t touches = 0;
  std::optional<accel::kdtree::TreeMetrics> metrics;  ///< Our builders only.
  std::uint64_t bytes = 0;  ///< Embree only: ours have theirs in the metrics.
  std::array<ChartTraced, kChartRays.size()> by_rays;
};

/// The rows of study = build, then those of study = trace; measured[i] belongs to contenders[i],
/// and each kind has `rays` rays.
std::vector<Row> chart_builder_rows(const ChartScene& scene,
                                    const std::vector<ChartContender>& contenders,
                                    const std::vector<ChartMeasured>& measured, std::size_t rays);

}  // namespace sightline::bench
