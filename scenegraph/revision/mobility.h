// Which nodes go into the dynamic tree, and what leaves the static one, when a revision is made.
#pragma once

#include <memory>
#include <memory_resource>
#include <span>
#include <unordered_map>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// Nodes made or copied for a revision; null: deleted.
using EditedNodes = std::pmr::unordered_map<model::NodeId, std::shared_ptr<model::Node>>;

/// What a batch of updates means for the two halves.
struct Marked {
  instances::NodeSet movers;
  instances::NodeSet departed;  ///< From the static half, if that has been begun.
  bool still_changed = false;   ///< What rests; in a half that nobody has looked at.
  bool moving_changed = false;
  std::vector<model::NodeId> changed;  ///< Nodes whose place, mesh or mask is other than before.
};

/// Before rays have looked at the static half a node is where its mobility says. From then on, a
/// node that is new or changed goes into the dynamic half, with all that is below it; its old place
/// has departed. Cost: the edited nodes and those above them.
Marked mark_movers(const Snapshot& base, const EditedNodes& edited);

/// Those of the nodes that are there and have none of the others above them.
instances::NodeSet topmost_of(const hierarchy::Hierarchy& hierarchy,
                              std::span<const model::NodeId> nodes);

}  // namespace sightline::scenegraph::revision
