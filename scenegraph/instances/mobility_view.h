// Which nodes the static tree and each dynamic tree hold. Dynamic trees hold moving nodes with all
// nodes below them (Shevtsov et al. 2007: one tree is kept, the other rebuilt).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"

namespace sightline::scenegraph::instances {

struct Instance;
class SceneTree;

/// What a dynamic tree holds: the nodes that changed after a revision, with all nodes below them.
struct MovedNodes {
  std::uint64_t after = 0;
  /// A list with each of these nodes that is in none of the parts; it may repeat some, and may have
  /// others. None: all nodes that have changed.
  std::optional<model::ChildList> candidates = std::nullopt;
  /// Trees that rays have asked for. Their instances that have not left them are used again.
  std::vector<std::shared_ptr<const SceneTree>> parts = {};
  /// The static tree, to whose center coordinates are relative.
  std::shared_ptr<const SceneTree> static_tree = nullptr;
};

/// A child of a group, with instances at or below it.
struct Member {
  const model::Node* node = nullptr;
  /// The summary of a group; null for an instance alone.
  const hierarchy::NodeSummary* group = nullptr;
  bool is_leaf = false;  ///< Whether a root of a dynamic side has no children.
  /// Its instance in another tree with the same center; null if it must be made.
  const Instance* known = nullptr;
};

/// The part of a hierarchy that one tree holds. The static side is the hierarchy without the nodes
/// that have changed (Hierarchy::changed_at); making its view costs the groups above those. A
/// dynamic side is the nodes that have changed after a revision; making its view costs their
/// number.
class MobilityView {
 public:
  /// The hierarchy must outlive this. `moved` is null for the static side.
  MobilityView(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved);

  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  bool is_static() const { return is_static_; }
  /// The roots of a dynamic side: the topmost of the nodes that changed, ascending; those that have
  /// instances, and those that have none.
  std::span<const Member> moved() const { return moved_; }
  std::span<const model::NodeId> moved_without_instances() const { return without_instances_; }
  /// The summary of the static side, in world space; that of a dynamic side has only `instances`
  /// and `entry_cost`.
  const hierarchy::NodeSummary& all() const { return all_; }
  /// The point to which the coordinates of trees are relative.
  const accel::geometry::Vec3d& center() const { return center_; }
  /// Whether a child of a node of this side belongs to it too.
  bool holds(const model::Node& node) const {
    return !is_static_ || hierarchy_.changed_at.find(node.id) == nullptr;
  }
  /// The summary of a node of this side that has children; `known` is the hierarchy's summary.
  const hierarchy::NodeSummary& group(model::NodeId id, const hierarchy::NodeSummary& known) const;

 private:
  void find_moved(const MovedNodes& moved);
  void leave_out_dynamic(const std::vector<model::NodeId>& roots);
  hierarchy::NodeSummary without_dynamic(model::NodeId group,
                                         const std::vector<model::NodeId>& changed) const;

  const hierarchy::Hierarchy& hierarchy_;
  const bool is_static_;
  std::vector<Member> moved_;
  std::vector<model::NodeId> without_instances_;
  std::unordered_map<model::NodeId, hierarchy::NodeSummary>
      without_dynamic_;  // by group above dynamic roots, on the static side
  hierarchy::NodeSummary all_;
  accel::geometry::Vec3d center_;
};

/// The nodes that have changed since they left the static tree and have no such node above them,
/// ascending.
std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy);

/// The last change of the node and of those above it, by Hierarchy::changed_at; 0: it is in the
/// static tree.
std::uint64_t last_change(const hierarchy::Hierarchy& hierarchy, model::NodeId id);

}  // namespace sightline::scenegraph::instances
