// The product's trees and walk with an exchangeable triangle test: only the test differs.
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

// Both functions follow scenegraph::trace step by step, including instances and their frames in
// double, and run in the calling thread's oneTBB arena in blocks of kRaysPerBlock. Trees do not
// change: cells that are not built are scanned. The snapshot of the instances must outlive the
// call.

/// Sets hits[i] to the nearest hit of rays[i]: only t, node, primitive and state.
void trace_closest(const scenegraph::instances::Instances& instances, TriangleTest test,
                   std::span<const accel::geometry::Ray> rays,
                   std::span<accel::geometry::Hit> hits);

/// Sets counts[i] to the number of distinct triangles that rays[i] meets within its limits.
void count_crossings(const scenegraph::instances::Instances& instances, TriangleTest test,
                     std::span<const accel::geometry::Ray> rays, std::span<std::uint32_t> counts);

}  // namespace sightline::bench
