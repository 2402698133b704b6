// One tree over meshes at their places: their triangles in the scene's coordinates.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/child.h"
#include "accel/wide/frame.h"
#include "accel/wide/placed_mesh.h"

namespace sightline::accel::mesh {

/// A mesh that will be in a flat tree.
struct FlatPart {
  wide::PlacedMesh placed;       ///< `first` is set by FlatTree.
  geometry::Aabb bounds;         ///< Of its finite triangles.
  wide::Matrix tree_from_local;  ///< To the coordinates of the flat tree.
  double error = 0;              ///< How far rounding of transforms may move points there.
};

/// A tree whose blocks have triangles of several meshes (wide::PlacedMesh), all of it built. Its
/// vertices are rounded; which triangles are hit is decided by the meshes' own vertices, in their
/// own frames. Threads: any.
class FlatTree {
 public:
  /// Returns null if there are too many triangles, floats cannot test them in the tree's sizes
  /// (wide::kLeastSize), or soon after `cancelled` is true. Reads all vertices and faces. Parallel
  /// in the caller's arena; not pinned (LazyTree::expand_all). Throws std::bad_alloc.
  static std::unique_ptr<const FlatTree> make(std::span<FlatPart> parts,
                                              const split::SplitRule& rule,
                                              kdtree::BuildCounters& built,
                                              const std::atomic<bool>* cancelled);

  /// Where rays begin that were prepared for frame(). Nothing below is deferred or a list.
  wide::Child root() const { return wide::Child::at(tree_->lazy_tree()->root()); }
  const wide::Frame& frame() const { return frame_; }
  const MeshTree& tree() const { return *tree_; }
  /// What packets need to know of the meshes; the question is the caller's.
  wide::PlacedMeshes meshes() const { return {.all = meshes_.data(), .mesh_of = mesh_of_.data()}; }
  std::uint64_t faces() const { return mesh_of_.size(); }
  std::uint64_t bytes() const;

 private:
  std::vector<wide::PlacedMesh> meshes_;
  std::vector<std::uint32_t> mesh_of_;  // see wide::PlacedMeshes
  wide::Frame frame_;
  std::unique_ptr<MeshTree> tree_;
};

}  // namespace sightline::accel::mesh
