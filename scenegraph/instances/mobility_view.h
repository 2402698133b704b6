// What each of a revision's two trees holds: the static one what rests, the dynamic one what moves,
// with all that hangs under it (Shevtsov et al.: a tree that lives on, and one made anew).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"

namespace sightline::scenegraph::instances {

enum class Half : std::uint8_t { kStatic, kDynamic };

/// A hierarchy as one half of it. The static half is the hierarchy less its movers; making its view
/// costs the groups above movers. The dynamic half is the movers, side by side.
class HalfView {
 public:
  /// The hierarchy must outlive this.
  HalfView(Half half, const hierarchy::Hierarchy& hierarchy);

  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  /// What the half begins with: roots, or the topmost movers.
  const std::vector<model::NodeId>& tops() const {
    return half_ == Half::kStatic ? *hierarchy_.roots : movers_;
  }
  /// Sum over the half, in world space.
  const hierarchy::Subtree& all() const { return all_; }
  /// Whether a child of a node of this half belongs to it too.
  bool holds(const model::Node& node) const {
    return half_ == Half::kDynamic || movers_.empty() || hierarchy_.movers.find(node.id) == nullptr;
  }
  /// Of what hangs under a node of this half that has children; `known` is that of the hierarchy.
  const hierarchy::Subtree& group(model::NodeId id, const hierarchy::Subtree& known) const;
  /// Whether any group differs from what the hierarchy knows.
  bool is_thinned() const { return !thinned_.empty(); }

 private:
  void thin_out();
  hierarchy::Subtree thinned(model::NodeId group, const std::vector<model::NodeId>& changed) const;

  const hierarchy::Hierarchy& hierarchy_;
  Half half_;
  std::vector<model::NodeId> movers_;  // the topmost, ascending
  std::unordered_map<model::NodeId, hierarchy::Subtree>
      thinned_;  // of the static half: groups above movers
  hierarchy::Subtree all_;
};

/// The movers that have none above them, ascending.
std::vector<model::NodeId> topmost_movers(const hierarchy::Hierarchy& hierarchy);

/// Whether the node, or one above it, moves.
bool is_moving(const hierarchy::Hierarchy& hierarchy, model::NodeId id);

}  // namespace sightline::scenegraph::instances
