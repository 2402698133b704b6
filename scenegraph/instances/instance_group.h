// Groups of the hierarchy that rays open into groups and instances.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/lazy/shared_slices.h"
#include "scenegraph/instances/instance.h"
#include "scenegraph/instances/mobility_view.h"
#include "scenegraph/instances/sibling_clusters.h"

namespace sightline::scenegraph::instances {

struct Opened;

/// A node with instances below it. Immutable apart from being opened, once.
struct Group {
  Group() = default;
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  ~Group();

  /// The node; null for the root group, which is all of the tree.
  const model::Node* node = nullptr;
  model::Affine world_from_local;
  /// The group's box, in the frame of Instance::box; holds all boxes below.
  accel::geometry::Aabb box;
  std::uint32_t number = 0;  ///< Its number as a group; the root group has none.
  /// The first numbers below the group. Numbers follow a walk, nodes before their children, and do
  /// not depend on what was opened or when.
  std::uint32_t first_instance = 0, first_group = 0, first_cluster = 0;
  /// Whether its box is nearly as large as its parent's, so that a reference to it would not help
  /// culling.
  bool opens_at_once = false;
  mutable std::atomic<Opened*> opened{nullptr};
};

/// The members of some of a group's children.
struct OpenedSlice {
  std::uint32_t first_group = 0, first_cluster = 0;  ///< The first numbers in the slice.
  std::vector<Instance> instances;
  std::vector<Group> groups;
  std::vector<accel::kdtree::Reference> refs;
};

/// The members of a group, made by the first thread that needs them; threads that arrive later
/// help.
struct Opened {
  explicit Opened(std::size_t children);

  /// How many numbers a slice of children needs.
  struct Numbers {
    std::uint64_t instances = 0, groups = 0, clusters = 0;
  };
  struct Siblings {
    SiblingClusters levels;
    std::vector<std::span<const accel::kdtree::Reference>>
        clusters;                    ///< Their members, by number from Group::first_cluster on.
    bool some_open_at_once = false;  ///< Whether some groups open at once.
  };

  accel::lazy::SharedSlices<Numbers> numbers;
  accel::lazy::SharedSlices<OpenedSlice> slices;
  accel::lazy::SharedSlices<Siblings> siblings{1};
  std::atomic<bool> listed{false};  ///< Whether instances can be found by number.
};

/// Finds the child of a complete group that has this number or is above the group that has it.
const Group& child_towards_group(const Opened& opened, std::uint32_t number);
/// Finds the child of a complete group that has the cluster with this number or is above the group
/// that has it.
const Group& child_towards_cluster(const Opened& opened, std::uint32_t number);

/// All of the tree as one group.
std::unique_ptr<Group> root_group(const MobilityView& view);

/// Returns by how much entry costs are shifted right to make weights, so that these sum below 2^32.
unsigned weight_shift(std::uint64_t total_cost);

/// The number of the group's children, those in other trees too; for the root group of a dynamic
/// tree, the number of roots in its view.
std::size_t count_children(const MobilityView& view, const Group& group);

/// Opens a group. Returns when `opened` is complete; its content is a pure function of the other
/// arguments. Throws std::bad_alloc.
void open_group(const MobilityView& view, const Group& group, unsigned shift, Opened& opened);

}  // namespace sightline::scenegraph::instances
