// The meshes of one half of a revision where they stand in the world, found as rays open the
// hierarchy, and the kd-tree over their boxes.
#pragma once

#include <atomic>
#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "accel/lazy/lazy_tree.h"
#include "scenegraph/instances/instance_group.h"
#include "scenegraph/instances/lazy_array.h"

namespace sightline::scenegraph::instances {

class InstanceList;

/// Of one half. What is opened stays; nothing else changes, but for the tree, which grows like any
/// other. Threads: all members, any; nobody waits for anybody.
class Instances {
 public:
  /// The hierarchy must outlive this.
  Instances(Half half, const hierarchy::Hierarchy& hierarchy);
  ~Instances();
  Instances(const Instances&) = delete;
  Instances& operator=(const Instances&) = delete;

  /// To be called before any other member, by every thread. Opens the roots, if that is not done.
  void begin() const;
  bool begun() const { return beginning_.load(std::memory_order_acquire) != nullptr; }

  /// How many there are, opened or not.
  std::size_t size() const { return instances_.size(); }
  /// A reference that some list or leaf of the tree holds, or all after open_all().
  const Instance& operator[](std::size_t index) const {
    return *instances_[index].load(std::memory_order_acquire);
  }

  /// Scene coordinates are taken relative to this point, so that the tree's floats are as fine as
  /// its extent allows.
  const accel::geometry::Vec3d& center() const { return center_; }
  /// Its leaves hold places of instances. Growing it is not a change of the snapshot.
  accel::lazy::LazyTree& tree() const { return *beginning().tree; }

  /// References that stand for all instances: the coarsest, openable or not.
  const std::vector<accel::kdtree::BoxRef>& coarsest() const { return beginning().coarsest; }
  /// Appends what an openable reference stands for; the same every time, whoever asked before.
  /// Throws std::bad_alloc.
  void open(const accel::kdtree::BoxRef& ref, std::vector<accel::kdtree::BoxRef>& out) const;
  /// Opens everything. In the order of a walk down from the roots, nodes before their children.
  InstanceList list() const;

  /// Groups and instances that have been placed so far.
  std::uint64_t placed() const { return placed_.load(std::memory_order_relaxed); }

 private:
  using Run = std::span<const accel::kdtree::BoxRef>;

  /// What is known once the roots are opened.
  struct Beginning {
    std::vector<accel::kdtree::BoxRef> coarsest;
    std::unique_ptr<accel::lazy::LazyTree> tree;
  };

  const Beginning& beginning() const { return *beginning_.load(std::memory_order_acquire); }
  const Group& group(std::uint32_t number) const;
  const Run& run(std::uint32_t number) const;
  const Opened& opened(const Group& group) const;
  void enlist(const Opened& opened) const;
  void append(const Opened& opened, std::size_t first,
              std::vector<accel::kdtree::BoxRef>& out) const;
  void open_all() const;

  HalfView view_;
  accel::geometry::Vec3d center_;
  unsigned weight_shift_;
  Zeroed<std::atomic<const Instance*>> instances_;
  std::unique_ptr<Group> whole_;
  mutable std::atomic<const Beginning*> beginning_{nullptr};
  mutable std::atomic<std::uint64_t> placed_{0};
  mutable std::atomic<bool> all_open_{false};
};

/// All instances, opened. A view.
class InstanceList {
 public:
  explicit InstanceList(const Instances& instances) : instances_(&instances) {}

  class Iterator {
   public:
    using difference_type = std::ptrdiff_t;
    using value_type = Instance;

    Iterator() = default;
    Iterator(const Instances& instances, std::size_t at) : instances_(&instances), at_(at) {}
    const Instance& operator*() const { return (*instances_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++at_;
      return before;
    }
    bool operator==(const Iterator& o) const { return at_ == o.at_; }

   private:
    const Instances* instances_ = nullptr;
    std::size_t at_ = 0;
  };

  Iterator begin() const { return {*instances_, 0}; }
  Iterator end() const { return {*instances_, size()}; }
  std::size_t size() const { return instances_->size(); }
  bool empty() const { return size() == 0; }
  const Instance& operator[](std::size_t i) const { return (*instances_)[i]; }

 private:
  const Instances* instances_;
};

}  // namespace sightline::scenegraph::instances
