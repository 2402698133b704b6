// The hierarchy as the scene's tree sees it: groups that are opened into groups and instances.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/aabb.h"
#include "scenegraph/instances/mobility_view.h"
#include "scenegraph/instances/shared_slices.h"
#include "scenegraph/instances/sibling_clusters.h"

namespace sightline::scenegraph::instances {

/// A node that carries a mesh with a finite triangle, where it stands in the world.
struct Instance {
  model::Affine local_from_world;
  bool mirrored = false;      ///< The transform turns windings around.
  accel::geometry::Aabb box;  ///< World, less Instances::center(), rounded outward.
  model::NodeId node = 0;
  std::uint32_t mask = accel::geometry::kAllMasks;
  std::uint32_t index = 0;  ///< Its place in Instances.
  const model::Mesh* mesh = nullptr;
  std::atomic<bool>* entered = nullptr;
};

struct Opened;

/// A node with instances below it. Immutable, but for being opened, once.
struct Group {
  Group() = default;
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  ~Group();

  const model::Node* node = nullptr;  ///< Null: all of the half.
  model::Affine world_from_local;
  accel::geometry::Aabb box;  ///< As of Instance; holds the boxes of all that is below.
  std::uint32_t number = 0;   ///< Among the groups; all of the half has none.
  /// From here on what is below is numbered, in the order of a walk, node before children. The
  /// numbers do not depend on what was opened, nor when.
  std::uint32_t first_instance = 0, first_group = 0, first_run = 0;
  /// Nearly as large as what it was opened from, or all of that: of no use as a reference.
  bool at_once = false;
  mutable std::atomic<Opened*> opened{nullptr};
};

/// What some of a group's children are opened into.
struct OpenedSlice {
  std::uint32_t first_group = 0, first_run = 0;  ///< As of Group.
  std::vector<Instance> instances;
  std::vector<Group> groups;
  std::vector<accel::kdtree::BoxRef> refs;
};

/// What a group is opened into, made by whoever needs it first and those who come meanwhile.
struct Opened {
  explicit Opened(std::size_t children);

  /// How many numbers a slice of children takes.
  struct Numbers {
    std::uint64_t instances = 0, groups = 0, runs = 0;
  };
  struct Siblings {
    SiblingRuns levels;
    std::vector<std::span<const accel::kdtree::BoxRef>>
        runs;                   ///< By number, from Group::first_run.
    bool some_at_once = false;  ///< Of the groups.
  };

  SharedSlices<Numbers> numbers;
  SharedSlices<OpenedSlice> slices;
  SharedSlices<Siblings> siblings{1};
  std::atomic<bool> listed{false};  ///< The instances can be found by number.
};

/// Of a complete group's children, the one that has this number or is above the group that has it.
const Group& child_towards_group(const Opened& opened, std::uint32_t number);
/// Of a complete group's children, the one that has the run with this number or is above the group
/// that has it.
const Group& child_towards_run(const Opened& opened, std::uint32_t number);

/// All of the half as one group.
std::unique_ptr<Group> whole_half(const HalfView& view, const accel::geometry::Vec3d& center);

/// How weights are made from prices: shifted right by this, so that they sum below 2^32.
unsigned weight_shift(std::uint64_t total_price);

/// The group's children, those that the half does not hold too; of the half, its tops.
const std::vector<model::NodeId>& children_of(const HalfView& view, const Group& group);

/// Returns when `opened` is complete, which is a pure function of the other arguments. Throws
/// std::bad_alloc.
void open_group(const HalfView& view, const Group& group, const accel::geometry::Vec3d& center,
                unsigned shift, Opened& opened);

}  // namespace sightline::scenegraph::instances
