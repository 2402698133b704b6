// Which nodes the static tree and each dynamic tree hold. Dynamic trees hold moving nodes with all
// nodes below them (Shevtsov et al. 2007: one tree is kept, the other rebuilt).
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"

namespace sightline::scenegraph::instances {

/// What a dynamic tree holds: the nodes that changed after a revision, with all nodes below them.
struct MovedNodes {
  std::uint64_t after = 0;
  /// Has each of these nodes. May repeat some, and may have others. Nothing: all that have changed.
  std::optional<model::ChildList> candidates = std::nullopt;
};

/// The candidates, or the nodes that have an entry in Hierarchy::changed_at.
std::vector<model::NodeId> candidates_of(const MovedNodes& moved,
                                         const hierarchy::Hierarchy& hierarchy);

/// The part of a hierarchy that one tree holds. The static side is the hierarchy without the nodes
/// that have changed (Hierarchy::changed_at); making its view costs the groups above those. A
/// dynamic side is the nodes that have changed after a revision; making its view costs their
/// number.
class MobilityView {
 public:
  /// The hierarchy must outlive this. Null: the static side.
  MobilityView(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved);

  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  /// Where the side begins: the scene's roots, or the topmost of the nodes that changed.
  const model::ChildList& roots() const { return is_static_ ? *hierarchy_.roots : dynamic_roots_; }
  /// Sum over the side, in world space.
  const hierarchy::NodeSummary& all() const { return all_; }
  /// Whether a child of a node of this side belongs to it too.
  bool holds(const model::Node& node) const {
    return !is_static_ || hierarchy_.changed_at.find(node.id) == nullptr;
  }
  /// The summary of a node of this side that has children; `known` is the hierarchy's summary.
  const hierarchy::NodeSummary& group(model::NodeId id, const hierarchy::NodeSummary& known) const;

 private:
  void leave_out_dynamic();
  hierarchy::NodeSummary without_dynamic(model::NodeId group,
                                         const std::vector<model::NodeId>& changed) const;

  const hierarchy::Hierarchy& hierarchy_;
  const bool is_static_;
  model::ChildList dynamic_roots_;  // the topmost, ascending
  std::unordered_map<model::NodeId, hierarchy::NodeSummary>
      without_dynamic_;  // of the static side: groups above dynamic roots
  hierarchy::NodeSummary all_;
};

/// The nodes that have changed since they left the static tree and have no such node above them,
/// ascending.
std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy);

/// The last change of the node and of those above it, by Hierarchy::changed_at; 0: it is in the
/// static tree.
std::uint64_t last_change(const hierarchy::Hierarchy& hierarchy, model::NodeId id);

}  // namespace sightline::scenegraph::instances
