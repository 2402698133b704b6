// One tree over meshes at their places: the blocks of their own trees, copied into the scene's
// coordinates.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/kd_tree.h"
#include "accel/wide/frame.h"
#include "accel/wide/placed_mesh.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::wide {

/// A mesh that will be in a flat tree.
struct FlatPart {
  PlacedMesh placed;           ///< `first` is set by FlatTree.
  const kdtree::KdTree* tree;  ///< Of leaf blocks.
  const Frame* frame;          ///< That of `tree`.
  Matrix tree_from_local;      ///< To the coordinates of the flat tree.
  double error = 0;            ///< How far rounding of transforms may move points there.
};

/// An instance that is entered by itself: a leaf of the flat tree is the list of its id.
struct ClosedInstance {
  std::uint32_t id = 0;
  geometry::Aabb box;
};

/// A tree whose blocks have triangles of several meshes (PlacedMesh). Its lists have the ids of
/// other instances, and of meshes where a cell of theirs was not built. Vertices in blocks are
/// rounded; which triangles are hit is decided by the meshes' own vertices, in their own frames.
/// Threads: any.
class FlatTree {
 public:
  /// Returns null if there were fewer blocks than `least`, or too many triangles, or soon after
  /// `cancelled` is true. Parallel in the caller's arena; pinned. Throws std::bad_alloc.
  static std::unique_ptr<const FlatTree> make(std::span<FlatPart> parts,
                                              std::span<const ClosedInstance> closed,
                                              std::size_t least,
                                              const std::atomic<bool>* cancelled);

  const WideTree& tree() const { return *tree_; }
  const Frame& frame() const { return frame_; }
  std::span<const PlacedMesh> meshes() const { return meshes_; }
  std::size_t blocks() const { return blocks_; }
  /// Whether all cells of its meshes were built: no mesh is in a block and in a list.
  bool is_complete() const { return complete_; }
  std::uint64_t bytes() const;

 private:
  std::vector<PlacedMesh> meshes_;
  Frame frame_;
  std::unique_ptr<const WideTree> tree_;
  std::size_t blocks_ = 0;
  bool complete_ = true;
};

}  // namespace sightline::accel::wide
