// The triangles of a case as wide trees.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "accel/blocks/block_builder.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/wide/frame.h"
#include "accel/wide/wide_tree.h"

namespace sightline::tests {

class VerdictTree {
 public:
  /// The mesh outlives the trees. is_made() is false for sizes that are never compiled.
  explicit VerdictTree(const accel::geometry::MeshView& mesh);

  bool is_made() const { return frame_.has_value(); }
  const accel::wide::Frame& frame() const { return *frame_; }
  /// As the builder divides the triangles, and with a leaf for each.
  const accel::wide::WideTree& dense() const { return *dense_; }
  const accel::wide::WideTree& single() const { return *single_; }
  /// All blocks of both.
  const std::vector<const std::uint32_t*>& blocks() const { return blocks_; }

  /// Relative to the center.
  const accel::geometry::Aabb& box(std::size_t face) const { return boxes_[face]; }
  std::array<accel::geometry::Vec3f, 3> corners(std::size_t face) const;

 private:
  void list_blocks(accel::kdtree::Slot at);

  accel::geometry::MeshView mesh_;
  std::optional<accel::wide::Frame> frame_;
  std::unique_ptr<accel::wide::WideTree> dense_, single_;
  std::vector<const std::uint32_t*> blocks_;
  std::vector<accel::geometry::Aabb> boxes_;
};

}  // namespace sightline::tests
