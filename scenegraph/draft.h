// A revision in the making: edits on top of a snapshot, seen by nobody until published.
#pragma once

#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "accel/result.h"
#include "scenegraph/snapshot.h"
#include "scenegraph/update.h"

namespace sightline::scenegraph {

/// One writer. After an error the draft is to be thrown away.
class Draft {
 public:
  Draft(const Snapshot& base, NodeId next_id)
      : base_(base), roots_(base.roots()), next_id_(next_id) {}

  Status apply(const Update& update);

  /// Whether every mesh below a node that was put or moved can be reached by rays: its world
  /// transform is invertible.
  Status check_transforms() const;

  /// Ids of PutNode's nodes, in order.
  const std::vector<NodeId>& put_nodes() const { return put_nodes_; }
  NodeId next_id() const { return next_id_; }

  std::shared_ptr<const Snapshot> publish(std::uint64_t revision) &&;

 private:
  Status put(const PutNode& put);
  Status set_transforms(const SetTransforms& set);
  Status remove(const DeleteNode& removal);

  Result<NodeId> resolve(NodeRef ref) const;
  const Node* find(NodeId id) const;
  /// The node for editing: copied from the base the first time.
  Node& edit(NodeId id);
  std::vector<NodeId>& siblings(NodeId parent);
  Status check_place(NodeId node, NodeId parent) const;
  int height(NodeId node) const;
  Affine world_from_local(const Node& node) const;
  Status check_below(const Node& node, const Affine& world) const;

  const Snapshot& base_;
  std::vector<NodeId> roots_;
  NodeId next_id_;
  std::unordered_map<NodeRef, NodeId> aliases_;
  /// Nodes made or copied by this draft; null: deleted.
  std::unordered_map<NodeId, std::shared_ptr<Node>> edited_;
  std::unordered_set<NodeId> moved_;
  std::vector<NodeId> put_nodes_;
};

}  // namespace sightline::scenegraph
