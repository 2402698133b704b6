// Spatial splits: a node's references are divided by a plane. Source: Stich et al. 2009,
// sections 4.2 and 4.4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/spatial_bins.h"

namespace sightline::accel::published::bvh {

/// A fragment on both sides of a plane, and the side or sides it goes to.
struct Straddler {
  enum class Goes : std::uint8_t { kLeft, kRight, kBoth };

  Fragment whole;
  geometry::Aabb left,
      right;  ///< Boxes of the parts of the triangle on each side; empty if there is none.
  Goes goes = Goes::kBoth;
};

/// A planned split of a node by a plane.
struct PlaneSplit {
  std::size_t axis = 0;
  float position = 0;
  std::vector<Straddler> straddlers;   ///< Sorted by Fragment::order.
  geometry::Aabb left_box, right_box;  ///< Bounds of the children.
  std::size_t left = 0, right = 0;     ///< Numbers of references.

  /// Number of references that the split adds.
  std::size_t added(std::size_t size) const { return left + right - size; }
  /// Sum over both children of half area times references.
  double sum() const {
    return half_area(left_box) * static_cast<double>(left) +
           half_area(right_box) * static_cast<double>(right);
  }
  /// Whether both children are smaller than the node, in number or in surface.
  bool reduces(const CenterLists& node) const;
};

/// Clips straddlers at the plane. The parts of a fragment cover every point of the triangle that
/// the fragment covered. A fragment whose triangle is on one side only goes to that side. With
/// `unsplit`, straddlers stay whole where that costs less by the formula of section 4.4; they are
/// decided one by one in their order, each with the boxes and numbers that the ones before it
/// leave.
///
/// Touches: a pass over the list; touches_prepare: two boxes a straddler.
void plan_plane_split(const geometry::MeshView& mesh, const CenterLists& node,
                      const SpatialSplit& split, bool unsplit, PlaneSplit& plan,
                      kdtree::BuildCounters& counters);

/// Divides lists as planned: the left lists stay in their memory, the right lists go to `buffer`,
/// which has capacity for 3 * plan.right fragments. Touches: a pass per axis.
ListHalves divide_by_plane(const CenterLists& node, const PlaneSplit& plan, Fragment* buffer,
                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
