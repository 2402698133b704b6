// One part of the study: how fast each builder is, and what its tree costs to trace.
#pragma once

#include <vector>

#include "accel/result.h"
#include "tests/bench/charts/configurations.h"
#include "tests/bench/charts/plan.h"
#include "tests/bench/charts/scenes.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// A row of study = build a contender, then one of study = trace a contender and kind of rays, over
/// the scene as one mesh. Contenders take turns within each of `common.repeat` rounds, every other
/// round backward. Relative figures are over kExactSweep, and missing where that is. Runs in the
/// calling thread's oneTBB arena.
/// Errors: kDataLoss: answers that differ from brute force or from another builder's.
Result<std::vector<Row>> chart_builders(const ChartScene& scene,
                                        const std::vector<ChartContender>& contenders,
                                        const CommonOptions& common, const ChartPlan& plan);

}  // namespace sightline::bench
