// What each of a revision's two trees holds: the static one what rests, the dynamic one what moves,
// with all that hangs under it (Shevtsov et al.: a tree that lives on, and one made anew).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"

namespace sightline::scenegraph {

enum class Half : std::uint8_t { kStatic, kDynamic };

/// A hierarchy as one half of it. The static half is the hierarchy less its movers; making its view
/// costs the groups above movers. The dynamic half is the movers, side by side.
class HalfView {
 public:
  /// The hierarchy must outlive this.
  HalfView(Half half, const Hierarchy& hierarchy);

  const Hierarchy& hierarchy() const { return hierarchy_; }
  /// What the half begins with: roots, or the topmost movers.
  const std::vector<NodeId>& tops() const {
    return half_ == Half::kStatic ? *hierarchy_.roots : movers_;
  }
  /// Sum over the half, in world space.
  const Subtree& all() const { return all_; }
  /// Whether a child of a node of this half belongs to it too.
  bool holds(const Node& node) const {
    return half_ == Half::kDynamic || movers_.empty() || hierarchy_.movers.find(node.id) == nullptr;
  }
  /// Of what hangs under a node of this half that has children; `known` is that of the hierarchy.
  const Subtree& group(NodeId id, const Subtree& known) const;
  /// Whether any group differs from what the hierarchy knows.
  bool is_thinned() const { return !thinned_.empty(); }

 private:
  void thin_out();
  Subtree thinned(NodeId group, const std::vector<NodeId>& changed) const;

  const Hierarchy& hierarchy_;
  Half half_;
  std::vector<NodeId> movers_;                   // the topmost, ascending
  std::unordered_map<NodeId, Subtree> thinned_;  // of the static half: groups above movers
  Subtree all_;
};

/// The movers that have none above them, ascending.
std::vector<NodeId> topmost_movers(const Hierarchy& hierarchy);

/// Whether the node, or one above it, moves.
bool is_moving(const Hierarchy& hierarchy, NodeId id);

}  // namespace sightline::scenegraph
