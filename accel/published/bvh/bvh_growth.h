// Where a hierarchy under construction puts its nodes and leaves, whichever way it is grown.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/kdtree/reserved_array.h"
#include "accel/published/bvh/bvh.h"

namespace sightline::accel::published::bvh {

/// Where the list of a node becomes a leaf.
struct BvhLeafRule {
  /// Lists longer than this are split, whatever it costs (Stich et al. 2009, section 5: until eight
  /// or fewer). Range 1 to 64.
  std::uint32_t leaf_size = 8;
  /// Shorter lists are split, too, where the heuristic says that it pays; off: never, as in the
  /// paper.
  bool split_small = false;
  double traverse = 1;     ///< C_t: visiting an inner node. Range >= 0.
  double intersect = 1.5;  ///< C_i: testing a triangle. Range > 0.

  bool operator==(const BvhLeafRule&) const = default;

  /// Whether a list of that many references stays a leaf, if its best split costs so much: the sum
  /// over both children of half area times references.
  bool keeps(std::size_t references, double half_area_of_box, double split_sum) const {
    if (references > leaf_size) return false;
    if (!split_small || references < 2) return true;
    return intersect * static_cast<double>(references) * half_area_of_box <=
           traverse * half_area_of_box + intersect * split_sum;
  }
};

/// Threads: leaf and inner from any.
class BvhGrowth {
 public:
  /// Room for a hierarchy over so many references, those made by splitting included. Below 2^32.
  /// `repeats`: leaves name what is listed twice twice.
  explicit BvhGrowth(std::size_t references, bool repeats = false);

  /// A leaf over these references, in that order; one that is listed twice is named once, unless
  /// with `repeats`.
  BvhChild leaf(std::span<const kdtree::Reference> refs, const geometry::Aabb& box);

  /// An inner node; its box is the union of its children's.
  BvhChild inner(const BvhChild& left, const BvhChild& right);

  /// The hierarchy below that place, in its final order and exactly as large as it is. Whatever is
  /// not below it is dropped.
  Bvh finish(const BvhChild& root) const;

 private:
  kdtree::ReservedArray<BvhNode> nodes_;
  kdtree::ReservedArray<std::uint32_t> ids_;
  bool repeats_;
  std::atomic<std::size_t> nodes_used_{0}, ids_used_{0};
};

/// The box around references; empty for none.
inline geometry::Aabb bounds_of(std::span<const kdtree::Reference> refs) {
  geometry::Aabb box;
  for (const kdtree::Reference& ref : refs) box.grow(ref.bounds());
  return box;
}

}  // namespace sightline::accel::published::bvh
