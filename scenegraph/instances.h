// The meshes of a revision where they stand in the world, and the kd-tree over their boxes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "accel/lazy/lazy_tree.h"
#include "scenegraph/node.h"

namespace sightline::scenegraph {

struct Instance {
  Affine local_from_world;
  bool mirrored = false;  ///< The transform turns windings around.
  accel::Aabb box;        ///< World, less Instances::center(), rounded outward.
  NodeId node = 0;
  std::uint32_t mask = accel::kAllMasks;
  const Mesh* mesh = nullptr;
  std::atomic<bool>* entered = nullptr;
};

/// World space in double.
struct WorldBounds {
  Vec3d lo{accel::kInfinity, accel::kInfinity, accel::kInfinity};
  Vec3d hi{-accel::kInfinity, -accel::kInfinity, -accel::kInfinity};
  bool empty() const { return !(lo.x <= hi.x); }
  void grow(const Vec3d& p);
};

class Snapshot;

/// Made once per snapshot and immutable, but for the tree, which grows like any other.
class Instances {
 public:
  /// Every node of the snapshot that carries a mesh with at least one finite triangle.
  explicit Instances(const Snapshot& snapshot);

  const std::vector<Instance>& list() const { return list_; }
  /// Scene coordinates are taken relative to this point, so that the tree's floats are as fine as
  /// its extent allows.
  const Vec3d& center() const { return center_; }
  /// References are places in list(). Growing it is not a change of the snapshot.
  accel::LazyTree& tree() const { return *tree_; }
  /// The distinct meshes.
  const std::vector<const Mesh*>& meshes() const { return meshes_; }

 private:
  std::vector<Instance> list_;
  std::vector<const Mesh*> meshes_;
  Vec3d center_;
  mutable std::unique_ptr<accel::LazyTree> tree_;
};

/// World transform of a node: its ancestors' transforms applied from the root down, in double.
Affine world_from_local(const Snapshot& snapshot, const Node& node);

}  // namespace sightline::scenegraph
