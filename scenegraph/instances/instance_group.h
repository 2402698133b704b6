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

  const model::Node* node = nullptr;  ///< Null: the root group, all of the tree.
  model::Affine world_from_local;
  accel::geometry::Aabb box;  ///< As Instance::box; holds all boxes below.
  std::uint32_t number = 0;   ///< Among the groups; the root group has none.
  /// The first numbers below the group. Numbers follow a walk, nodes before their children, and do
  /// not depend on what was opened or when.
  std::uint32_t first_instance = 0, first_group = 0, first_cluster = 0;
  /// Its box is nearly as large as its parent's, so a reference to it would not help culling.
  bool opens_at_once = false;
  mutable std::atomic<Opened*> opened{nullptr};
};

/// The members of some of a group's children.
struct OpenedSlice {
  std::uint32_t first_group = 0, first_cluster = 0;  ///< As of Group.
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
        clusters;                    ///< By number, from Group::first_cluster.
    bool some_open_at_once = false;  ///< Of the groups.
  };

  accel::lazy::SharedSlices<Numbers> numbers;
  accel::lazy::SharedSlices<OpenedSlice> slices;
  accel::lazy::SharedSlices<Siblings> siblings{1};
  std::atomic<bool> listed{false};  ///< The instances can be found by number.
};

/// Of a complete group's children, the one that has this number or is above the group that has it.
const Group& child_towards_group(const Opened& opened, std::uint32_t number);
/// Of a complete group's children, the one that has the run with this number or is above the group
/// that has it.
const Group& child_towards_cluster(const Opened& opened, std::uint32_t number);

/// All of the tree as one group.
std::unique_ptr<Group> root_group(const MobilityView& view);

/// How weights are made from entry costs: shifted right by this, so that they sum below 2^32.
unsigned weight_shift(std::uint64_t total_cost);

/// Of the group's children, those in other trees too; of the root group's, those where the view
/// begins.
std::size_t count_children(const MobilityView& view, const Group& group);

/// Returns when `opened` is complete, which is a pure function of the other arguments. Throws
/// std::bad_alloc.
void open_group(const MobilityView& view, const Group& group, unsigned shift, Opened& opened);

}  // namespace sightline::scenegraph::instances
