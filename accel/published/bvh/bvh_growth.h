// Nodes and leaves of a hierarchy under construction, the same for all methods.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/published/bvh/bvh.h"
#include "accel/published/bvh/reserved_array.h"

namespace sightline::accel::published::bvh {

/// When the list of a node becomes a leaf.
struct BvhLeafRule {
  /// Longer lists are always split (Stich et al. 2009, section 5: until eight or fewer). Range 1 to
  /// 64.
  std::uint32_t leaf_size = 8;
  /// Whether shorter lists are split, too, if that lowers the SAH cost. The paper never does.
  bool split_small = false;
  double traverse = 1;     ///< C_t: visiting an inner node. Range >= 0.
  double intersect = 1.5;  ///< C_i: testing a triangle. Range > 0.

  bool operator==(const BvhLeafRule&) const = default;

  /// Whether a list of that many references becomes a leaf. split_sum: the sum over both children
  /// of half area times references, for the best split.
  bool keeps(std::size_t references, double half_area_of_box, double split_sum) const {
    if (references > leaf_size) return false;
    if (!split_small || references < 2) return true;
    return intersect * static_cast<double>(references) * half_area_of_box <=
           traverse * half_area_of_box + intersect * split_sum;
  }
};

/// Makes the nodes and leaves of a hierarchy. Threads: leaf() and inner() any; finish() after all
/// of them.
class BvhGrowth {
 public:
  /// Reserves a hierarchy over `references` references, including those made by splitting; fewer
  /// than 2^32. `repeats`: a leaf keeps duplicate ids.
  explicit BvhGrowth(std::size_t references, bool repeats = false);

  /// Makes a leaf over these references, in their order; duplicate ids are dropped, unless
  /// `repeats`.
  BvhChild leaf(std::span<const kdtree::Reference> refs, const geometry::Aabb& box);

  /// Makes an inner node. Its box is the union of its children's.
  BvhChild inner(const BvhChild& left, const BvhChild& right);

  /// Returns the hierarchy below `root`, in its final order, in arrays without unused capacity.
  /// Other nodes are dropped.
  Bvh finish(const BvhChild& root) const;

 private:
  ReservedArray<BvhNode> nodes_;
  ReservedArray<std::uint32_t> ids_;
  bool repeats_;
  std::atomic<std::size_t> nodes_used_{0}, ids_used_{0};
};

}  // namespace sightline::accel::published::bvh
