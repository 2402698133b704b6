// What rays see of a scene, by the selection of their query, what has left its trees, and masks.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "accel/geometry/ray_columns.h"
#include "accel/wide/packet.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/query/selection.h"

namespace sightline::scenegraph::query {

/// Whether rays see an instance of a tree. `selection`: null selects all.
inline bool is_seen(const instances::OpenTree& tree, std::size_t id, const Selection* selection) {
  if (tree.removed != nullptr && tree.removed->has(id)) return false;
  return selection == nullptr || selection->selects(tree.first + id);
}

/// The masks of a packet's rays.
class Masks {
 public:
  void read(const accel::geometry::MaskColumn& column, const RayPacket& packet) {
    if (column.stride == 0) {
      masks_.fill(column[0]);
      see_all_ = masks_[0] == accel::geometry::kAllMasks;
      return;
    }
    std::uint32_t common = accel::geometry::kAllMasks;
    for (std::size_t i = 0; i < masks_.size(); ++i) {
      masks_[i] = column[packet.first + std::min(i, packet.count - 1)];
      common &= masks_[i];
    }
    see_all_ = common == accel::geometry::kAllMasks;
  }

  /// Whether every ray sees all instances with a mask that is not 0.
  bool see_all() const { return see_all_; }
  /// The rays of `lanes` that see an instance with this mask.
  std::uint32_t seeing(std::uint32_t mask, std::uint32_t lanes) const {
    if (see_all_) return mask != 0 ? lanes : 0;
    for (std::size_t i = 0; i < masks_.size(); ++i) {
      if ((masks_[i] & mask) == 0) lanes &= ~(1u << i);
    }
    return lanes;
  }

 private:
  std::array<std::uint32_t, accel::wide::kLanes> masks_;
  bool see_all_ = true;  // all bits of all masks are set
};

}  // namespace sightline::scenegraph::query
