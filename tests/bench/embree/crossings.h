// Every triangle that a ray meets, by Embree.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"

namespace sightline::bench {

/// counts[i] is how many triangles rays[i] meets within its limits, each once: a filter notes every
/// hit and refuses it. The scene was made with RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION. Rays are
/// carried by `frame` in double and then rounded to float. In parallel.
void count_embree_crossings(RTCScene scene, std::span<const accel::geometry::Ray> rays,
                            const scenegraph::model::Affine& frame,
                            std::span<std::uint32_t> counts);

}  // namespace sightline::bench
