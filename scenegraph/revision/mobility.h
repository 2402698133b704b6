// Which nodes go into the dynamic tree, and which are removed from the static one, by a revision.
#pragma once

#include <atomic>
#include <memory>
#include <memory_resource>
#include <span>
#include <unordered_map>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// Nodes made or copied for a revision; null: deleted.
using EditedNodes = std::pmr::unordered_map<model::NodeId, std::shared_ptr<model::Node>>;

/// What a batch of updates means for the two trees.
struct MobilityChange {
  instances::NodeSet dynamic_roots;
  instances::NodeSet removed;   ///< From the static tree, if rays have opened it.
  bool static_changed = false;  ///< A static node changed before rays opened the static tree.
  bool dynamic_changed = false;
  std::vector<model::NodeId> changed;  ///< Nodes whose transform, parent, mesh or mask changed.
};

/// Before rays open the static tree, a node is in the tree that its mobility says. From then on, a
/// new or changed node goes into the dynamic tree with all nodes below it, and what the static tree
/// holds of it is removed. Cost: the edited nodes and those above them. Returns soon after
/// `cancelled` is true; the change is then incomplete.
MobilityChange classify_changes(const Snapshot& base, const EditedNodes& edited,
                                const std::atomic<bool>* cancelled = nullptr);

/// The nodes that exist and have none of the others above them.
instances::NodeSet topmost_of(const hierarchy::Hierarchy& hierarchy,
                              std::span<const model::NodeId> nodes);

}  // namespace sightline::scenegraph::revision
