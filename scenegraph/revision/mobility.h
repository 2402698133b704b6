// Which nodes go into the dynamic tree, and what leaves the static one, when a revision is made.
#pragma once

#include <memory>
#include <memory_resource>
#include <span>
#include <unordered_map>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph {

/// Nodes made or copied for a revision; null: deleted.
using EditedNodes = std::pmr::unordered_map<NodeId, std::shared_ptr<Node>>;

/// What a batch of updates means for the two halves.
struct Marked {
  NodeSet movers;
  NodeSet departed;            ///< From the static half, if that has been begun.
  bool still_changed = false;  ///< What rests; in a half that nobody has looked at.
  bool moving_changed = false;
  std::vector<NodeId> changed;  ///< Nodes whose place, mesh or mask is other than before.
};

/// Before rays have looked at the static half a node is where its mobility says. From then on, a
/// node that is new or changed goes into the dynamic half, with all that is below it; its old place
/// has departed. Cost: the edited nodes and those above them.
Marked mark_movers(const Snapshot& base, const EditedNodes& edited);

/// Those of the nodes that are there and have none of the others above them.
NodeSet topmost_of(const Hierarchy& hierarchy, std::span<const NodeId> nodes);

}  // namespace sightline::scenegraph
