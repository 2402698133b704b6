// Pictures of one view with growing numbers of rays, and their answers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/charts/plan.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

struct ChartPicture {
  std::vector<accel::geometry::Ray> rays;
  std::string hash;  ///< Hash of the answers.
};

/// One view with 1, 10, ... up to plan.largest_image rays; `kind` is overview or closeup. The
/// camera is the same for all. Answers come from full trees; those of all but the largest picture
/// are checked against brute force.
/// Errors: those of make_rays; kDataLoss.
Result<std::vector<ChartPicture>> chart_pictures(const SceneSource& scene, std::string_view kind,
                                                 std::uint64_t seed, const ChartPlan& plan);

}  // namespace sightline::bench
