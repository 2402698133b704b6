// The product's trees and the product's walk with a triangle test of one's choice: nothing but the
// test differs between two of these.
#pragma once

#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "scenegraph/instances/instance_list.h"

namespace sightline::bench {

enum class TriangleTest : std::uint8_t {
  kExact,       ///< accel::intersect.
  kPlainFloat,  ///< PlainFloat.
};

// Both follow scenegraph::trace step by step, instances and their frames in double included, and
// run in the calling thread's oneTBB arena in blocks of kRaysPerBlock. Trees stay as they are:
// cells that are not built are searched. The snapshot behind the instances must live.

/// hits[i] is the nearest hit of rays[i]: t, node, primitive and state alone.
void trace_closest(const scenegraph::instances::Instances& instances, TriangleTest test,
                   std::span<const accel::geometry::Ray> rays,
                   std::span<accel::geometry::Hit> hits);

/// counts[i] is how many triangles rays[i] meets within its limits, each once however many cells
/// hold it.
void count_crossings(const scenegraph::instances::Instances& instances, TriangleTest test,
                     std::span<const accel::geometry::Ray> rays, std::span<std::uint32_t> counts);

}  // namespace sightline::bench
