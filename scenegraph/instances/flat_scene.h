// The flat tree over the instances of a scene's tree.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <unordered_set>
#include <vector>

#include "accel/kdtree/reference.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/flat_tree.h"
#include "scenegraph/model/affine.h"

namespace sightline::scenegraph::model {
class Mesh;
}  // namespace sightline::scenegraph::model

namespace sightline::scenegraph::instances {

class Instances;

/// All instances of a scene's tree, in two trees: one over the triangles of those that are flat,
/// and one over the boxes of the others, which rays enter. Both are built. Threads: any.
class FlatScene {
 public:
  /// Makes instances flat whose meshes have no other instance, or few triangles, and are in memory.
  /// Opens all instances. Returns null where no more triangles would be flat than in `before`,
  /// which may be null, memory has no room for it, or soon after `cancelled` is true. Parallel in
  /// the caller's arena; not pinned. Throws std::bad_alloc.
  static std::unique_ptr<const FlatScene> make(const Instances& instances, const FlatScene* before,
                                               accel::kdtree::BuildCounters& built,
                                               const std::atomic<bool>* cancelled);

  const accel::mesh::FlatTree& triangles() const { return *triangles_; }
  /// Whether some instance of a mesh is flat.
  bool has(const model::Mesh* mesh) const { return meshes_.contains(mesh); }
  /// The others, and the tree over them, as Instances::tree(); null if there are none.
  const std::vector<accel::kdtree::Reference>& boxes() const { return boxes_; }
  accel::lazy::LazyTree* entered() const { return entered_.get(); }
  std::uint64_t bytes() const;

 private:
  void add_entered(std::vector<accel::kdtree::Reference> boxes,
                   accel::kdtree::BuildCounters& built);

  std::deque<model::Affine> transforms_;  // of flat instances, to the scene; others point to them
  std::unique_ptr<const accel::mesh::FlatTree> triangles_;
  std::unordered_set<const model::Mesh*> meshes_;
  std::vector<accel::kdtree::Reference> boxes_;
  std::unique_ptr<accel::lazy::LazyTree> entered_;
};

}  // namespace sightline::scenegraph::instances
