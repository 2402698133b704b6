// One part of the study: how long a picture of a given number of rays takes, from arrays to hits.
#pragma once

#include <vector>

#include "proto/result.h"
#include "tests/bench/charts/plan.h"
#include "tests/bench/charts/scenes.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// One row of study = image for every kind of picture (overview, closeup), way of building and
/// number of rays (1, 10, ...). The clock starts with vertex and index arrays in memory and nothing
/// computed from them. Ways take turns within each of `common.repeat` rounds. The largest traced
/// picture is traced in the first round only; larger ones are extrapolated from it and from the
/// cost of one more ray (basis = extrapolated; otherwise measured). Runs in the calling thread's
/// oneTBB arena.
/// Errors: kDataLoss: answers that differ from brute force or between ways.
Result<std::vector<Row>> chart_images(const ChartScene& scene, const CommonOptions& common,
                                      const ChartPlan& plan);

}  // namespace sightline::bench
