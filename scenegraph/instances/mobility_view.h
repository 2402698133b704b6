// Which nodes the static and the dynamic tree hold. The dynamic tree holds moving nodes with all
// nodes below them (Shevtsov et al. 2007: one tree is kept, the other rebuilt).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"

namespace sightline::scenegraph::instances {

enum class MobilitySide : std::uint8_t { kStatic, kDynamic };

/// The part of a hierarchy that one tree holds. The static side is the hierarchy without its
/// dynamic roots; making its view costs the groups above those. The dynamic side is the dynamic
/// roots.
class MobilityView {
 public:
  /// The hierarchy must outlive this.
  MobilityView(MobilitySide side, const hierarchy::Hierarchy& hierarchy);

  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  /// Where the side begins: the scene's roots, or the topmost dynamic roots.
  const model::ChildList& roots() const {
    return side_ == MobilitySide::kStatic ? *hierarchy_.roots : dynamic_roots_;
  }
  /// Sum over the side, in world space.
  const hierarchy::NodeSummary& all() const { return all_; }
  /// Whether a child of a node of this side belongs to it too.
  bool holds(const model::Node& node) const {
    return side_ == MobilitySide::kDynamic || dynamic_roots_.empty() ||
           hierarchy_.dynamic_roots.find(node.id) == nullptr;
  }
  /// The summary of a node of this side that has children; `known` is the hierarchy's summary.
  const hierarchy::NodeSummary& group(model::NodeId id, const hierarchy::NodeSummary& known) const;

 private:
  void leave_out_dynamic();
  hierarchy::NodeSummary without_dynamic(model::NodeId group,
                                         const std::vector<model::NodeId>& changed) const;

  const hierarchy::Hierarchy& hierarchy_;
  MobilitySide side_;
  model::ChildList dynamic_roots_;  // the topmost, ascending
  std::unordered_map<model::NodeId, hierarchy::NodeSummary>
      without_dynamic_;  // of the static side: groups above dynamic roots
  hierarchy::NodeSummary all_;
};

/// The dynamic roots that have none above them, ascending.
std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy);

/// Whether the node or one above it is a dynamic root.
bool is_dynamic(const hierarchy::Hierarchy& hierarchy, model::NodeId id);

}  // namespace sightline::scenegraph::instances
