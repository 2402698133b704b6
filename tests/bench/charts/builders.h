// One part of the study: how fast each builder is, and what its tree costs to trace.
#pragma once

#include <vector>

#include "proto/result.h"
#include "tests/bench/charts/configurations.h"
#include "tests/bench/charts/plan.h"
#include "tests/bench/charts/scenes.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// One row of study = build for each contender, then one of study = trace for each contender and
/// kind of rays, over the scene as one mesh. Contenders take turns within each of `common.repeat`
/// rounds, in reverse order every other round. Relative figures are over kExactSweep, and left out
/// where it is missing. Runs in the calling thread's oneTBB arena.
/// Errors: kDataLoss: answers that differ from brute force or from another builder's.
Result<std::vector<Row>> chart_builders(const ChartScene& scene,
                                        const std::vector<ChartContender>& contenders,
                                        const CommonOptions& common, const ChartPlan& plan);

}  // namespace sightline::bench
