// All triangles that a ray meets, by Embree.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"

namespace sightline::bench {

/// Sets counts[i] to the number of distinct triangles that rays[i] meets within its limits: a
/// filter records every hit and rejects it. The scene must have
/// RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION. Rays are transformed by `frame` in double and then
/// rounded to float. Parallel.
void count_embree_crossings(RTCScene scene, std::span<const accel::geometry::Ray> rays,
                            const scenegraph::model::Affine& frame,
                            std::span<std::uint32_t> counts);

}  // namespace sightline::bench
