// One part of the study: rays that methods lose on closed scenes, against how fast they are.
#pragma once

#include <vector>

#include "accel/result.h"
#include "tests/bench/charts/plan.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// The results of run_robust, as rows of study = missed: scene is the family, rays the kind. Exact
/// hits over the trees of some builders of each sort; Embree and plain float for comparison.
/// Errors: those of run_robust.
Result<std::vector<Row>> chart_missed(const CommonOptions& common, const ChartPlan& plan);

}  // namespace sightline::bench
