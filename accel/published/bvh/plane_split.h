// Splitting a node's references by a plane. Source: Stich et al. 2009, sections 4.2 and 4.4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/chopped_axis.h"

namespace sightline::accel::published::bvh {

/// A fragment that reaches to both sides of a plane, and what becomes of it.
struct Straddler {
  enum class Goes : std::uint8_t { kLeft, kRight, kBoth };

  Fragment whole;
  geometry::Aabb left,
      right;  ///< Around what of the triangle is on either side; empty for nothing.
  Goes goes = Goes::kBoth;
};

/// A node about to be split by a plane.
struct PlaneSplit {
  std::size_t axis = 0;
  float position = 0;
  std::vector<Straddler> straddlers;   ///< By order.
  geometry::Aabb left_box, right_box;  ///< Around what goes there.
  std::size_t left = 0, right = 0;     ///< How many go there.

  /// References that it adds.
  std::size_t added(std::size_t size) const { return left + right - size; }
  /// Of half area times references, over both children.
  double sum() const {
    return half_area(left_box) * static_cast<double>(left) +
           half_area(right_box) * static_cast<double>(right);
  }
  /// Whether both children are smaller than the node, in number or in surface.
  bool reduces(const CenterLists& node) const;
};

/// Cuts straddlers at the plane, exactly: every point of a triangle that the fragment was
/// responsible for stays in one of its parts. A fragment whose triangle reaches to one side only
/// goes there alone. With `unsplit`, straddlers stay whole where that costs less by the formula of
/// section 4.4: they are decided one after the other by their order, with the boxes and numbers
/// that came of those before.
///
/// Touches: a pass over the list; touches_prepare: two boxes a straddler.
void plan_plane_split(const geometry::MeshView& mesh, const CenterLists& node,
                      const SpatialSplit& split, bool unsplit, PlaneSplit& plan,
                      kdtree::BuildCounters& counters);

/// What goes left to where the lists were; what goes right to `buffer`, for 3 * plan.right. Touches:
/// a pass an axis.
ListHalves divide_by_plane(const CenterLists& node, const PlaneSplit& plan, Fragment* buffer,
                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
