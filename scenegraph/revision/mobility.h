// Which nodes a revision moves out of their trees.
#pragma once

#include <atomic>
#include <memory>
#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// Nodes made or copied for a revision; null: deleted.
using EditedNodes = std::pmr::unordered_map<model::NodeId, std::shared_ptr<model::Node>>;

/// What a batch of updates means for the trees.
struct MobilityChange {
  hierarchy::ChangeMap changed_at;  ///< The map of the new revision.
  /// Nodes that were made or deleted, or whose transform, parent, mesh, mask or mobility changed;
  /// ascending.
  std::vector<model::NodeId> changed;
  bool opened = false;  ///< Whether rays have opened the base's static tree.
};

/// Finds which nodes leave their trees. Before rays open the static tree, a node's mobility tells
/// whether it is in that tree. From then on, each new, changed or deleted node leaves its tree,
/// with all nodes below it. Cost: the edited nodes. Returns soon after `cancelled` is true; the
/// change is then incomplete.
MobilityChange classify_changes(const Snapshot& base, const EditedNodes& edited,
                                const std::atomic<bool>* cancelled = nullptr);

}  // namespace sightline::scenegraph::revision
