// A revision in the making: edits on top of a snapshot, seen by nobody until published.
#pragma once

#include <memory>
#include <memory_resource>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/deformations.h"
#include "scenegraph/revision/mobility.h"

namespace sightline::scenegraph {

/// One writer. After an error the draft is to be thrown away.
class Draft {
 public:
  Draft(const Snapshot& base, NodeId next_id)
      : base_(base), hierarchy_(base.hierarchy()), next_id_(next_id) {}

  Status apply(const Update& update);

  /// After the last update. Errors: kInvalidArgument if a mesh below a node that was put or moved
  /// cannot be reached by rays: its world transform is not invertible.
  Status finish();

  /// Ids of PutNode's nodes, in order.
  const std::vector<NodeId>& put_nodes() const { return put_nodes_; }
  NodeId next_id() const { return next_id_; }

  /// Nodes whose place, mesh or mask is other than before. After finish().
  const std::vector<NodeId>& changed() const { return marked_.changed; }

  /// After finish().
  std::shared_ptr<const Snapshot> publish(std::uint64_t revision) &&;

 private:
  Status put(const PutNode& put);
  Status set_transforms(const SetTransforms& set);
  Status remove(const DeleteNode& removal);
  Status patch(const PatchVertices& patch);

  Result<NodeId> resolve(NodeRef ref) const;
  const Node* find(NodeId id) const;
  /// The node for editing: copied from the base the first time.
  Node& edit(NodeId id);
  std::vector<NodeId>& siblings(NodeId parent);
  void join(NodeId id, NodeId parent);
  void leave(NodeId id, NodeId parent);
  std::vector<NodeId> children_now(const Node& node) const;
  void drop_left();
  Status deform();
  Status check_place(NodeId node, NodeId parent) const;
  int height(NodeId node) const;
  Affine world_from_local(const Node& node) const;
  Halves halves() const;
  Status check_transforms() const;
  Status check_below(const Node& node, const Affine& world) const;

  // Of the maps below: given back as a whole, not in a million pieces.
  std::pmr::monotonic_buffer_resource memory_;
  const Snapshot& base_;
  Hierarchy hierarchy_;                         // of the base, until finish()
  std::shared_ptr<std::vector<NodeId>> roots_;  // null: as in the base
  NodeId next_id_;
  std::pmr::unordered_map<NodeRef, NodeId> aliases_{&memory_};
  EditedNodes edited_{&memory_};
  /// By parent: children that are to be dropped from its list by finish().
  std::pmr::unordered_map<NodeId, std::unordered_set<NodeId>> left_{&memory_};
  Marked marked_;
  std::pmr::unordered_set<NodeId> moved_{&memory_};
  Deformations deformations_;
  std::vector<NodeId> put_nodes_;
};

}  // namespace sightline::scenegraph
