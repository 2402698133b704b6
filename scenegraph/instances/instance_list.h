// The instances of one of the trees of a scene, opened as rays need them, and the kd-tree over
// their boxes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"
#include "scenegraph/instances/instance.h"
#include "scenegraph/instances/lazy_array.h"
#include "scenegraph/instances/mobility_view.h"

namespace sightline::accel::lazy {
class LazyTree;
}  // namespace sightline::accel::lazy

namespace sightline::scenegraph::instances {

class FlatScene;
struct Group;
struct Opened;

/// The instances of one tree. Opened groups stay open and the kd-tree grows; nothing else changes.
/// Threads: all members, any; no thread waits for a stopped one, except in make_flat().
class Instances {
 public:
  /// The hierarchy must outlive this. `moved` is what a dynamic tree holds; null for the static
  /// tree.
  Instances(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved);
  ~Instances();
  Instances(const Instances&) = delete;
  Instances& operator=(const Instances&) = delete;

  /// Every thread must call this before any other member. Opens the roots at the first call.
  void begin() const;
  bool begun() const { return roots_.load(std::memory_order_acquire) != nullptr; }

  /// The number of instances, opened or not.
  std::size_t size() const { return instances_.size(); }
  /// An instance. Its reference was opened, as that of any in a list or leaf of the tree was.
  const Instance& operator[](std::size_t index) const {
    return *instances_[index].load(std::memory_order_acquire);
  }

  /// The transform of which Instance::local_from_world is the inverse, composed again.
  model::Affine world_from_local(const Instance& instance) const;

  /// The instances as far as they are flat, which batches of rays share; null where none is.
  std::shared_ptr<const FlatScene> flat() const;
  /// Counts entries of rays into instances that are not flat. Makes these flat once that has cost
  /// as much as making them, and again after twice as many.
  void count_entries(std::uint64_t entries, accel::kdtree::BuildCounters& built,
                     const std::atomic<bool>* cancelled) const;
  /// Makes instances flat, if more can be than are (FlatScene::make). Waits for a thread that does
  /// so, until `cancelled` is true. Throws std::bad_alloc.
  void make_flat(accel::kdtree::BuildCounters& built,
                 const std::atomic<bool>* cancelled = nullptr) const;
  /// Leaves it to the batches that have it. Returns its bytes.
  std::uint64_t drop_flat() const;

  /// Scene coordinates are taken relative to this point, so that the tree's floats are as fine as
  /// its extent allows.
  const accel::geometry::Vec3d& center() const { return view_.center(); }
  /// The kd-tree, whose leaves hold indices of instances. Growing it does not change the snapshot.
  accel::lazy::LazyTree& tree() const { return *opened_roots().tree; }
  /// Bytes of the tree, without the instances.
  std::uint64_t tree_bytes() const;

  /// References that stand for all instances: the coarsest, openable or not.
  const std::vector<accel::kdtree::Reference>& coarsest() const { return opened_roots().coarsest; }
  /// Appends the members of an openable reference: the same at every call, from any thread.
  /// Throws std::bad_alloc.
  void open(const accel::kdtree::Reference& ref, std::vector<accel::kdtree::Reference>& out) const;
  /// Opens all groups. Throws std::bad_alloc.
  void open_all() const;
  /// The members of a cluster, where they lie; none for other references.
  std::span<const accel::kdtree::Reference> members_of_cluster(
      const accel::kdtree::Reference& ref) const;
  /// Whether open() need not make the members of an openable reference.
  bool is_open(const accel::kdtree::Reference& ref) const;

  /// Calls visit(id, node, instance) for each root of a dynamic tree. `instance` is null unless the
  /// root is an instance without children.
  template <class Visit>
  void for_each_root(const Visit& visit) const {
    std::size_t index = 0;
    for (const Member& root : view_.moved()) {
      const Instance* instance = root.is_leaf ? &(*this)[index] : nullptr;
      visit(instance == nullptr ? root.node->id : instance->node, root.node, instance);
      index += root.group == nullptr ? 1 : root.group->instances;
    }
    for (const model::NodeId id : view_.moved_without_instances()) visit(id, nullptr, nullptr);
  }

  /// Groups and instances opened so far.
  std::uint64_t opened_members() const { return opened_members_.load(std::memory_order_relaxed); }

 private:
  using Cluster = std::span<const accel::kdtree::Reference>;

  /// What is made when the roots are opened.
  struct Roots {
    std::vector<accel::kdtree::Reference> coarsest;
    std::unique_ptr<accel::lazy::LazyTree> tree;
  };

  const Roots& opened_roots() const { return *roots_.load(std::memory_order_acquire); }
  const Group& group(std::uint32_t number) const;
  const Cluster& cluster(std::uint32_t number) const;
  const Opened& opened(const Group& group) const;
  void enlist(const Opened& opened) const;
  void append(const Opened& opened, std::size_t first,
              std::vector<accel::kdtree::Reference>& out) const;

  MobilityView view_;
  unsigned weight_shift_;
  LazyArray<std::atomic<const Instance*>> instances_;
  std::unique_ptr<Group> root_group_;
  mutable std::atomic<const Roots*> roots_{nullptr};
  // An entry takes 120 to 290 ns more than a walk of a flat tree. To make the tree takes about as
  // long for each triangle.
  mutable std::atomic<std::uint64_t> entries_{0}, flat_at_;
  mutable std::mutex making_flat_;
  mutable std::mutex flat_mutex_;  // held for one copy
  mutable std::shared_ptr<const FlatScene> flat_;
  mutable std::atomic<std::uint64_t> opened_members_{0};
};

}  // namespace sightline::scenegraph::instances
