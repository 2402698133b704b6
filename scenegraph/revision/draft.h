// Edits on top of a snapshot, private to the writer until published.
#pragma once

#include <atomic>
#include <memory>
#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/deformations.h"
#include "scenegraph/revision/levels.h"
#include "scenegraph/revision/mobility.h"

namespace sightline::scenegraph::revision {

/// A revision in the making. Threads: one writer. After an error the draft must be discarded. Once
/// `cancelled` is true, apply() and finish() end soon with kCancelled.
class Draft {
 public:
  /// `charge`: see Deformations.
  Draft(const Snapshot& base, model::NodeId next_id, model::ChargeBytes charge = {},
        const std::atomic<bool>* cancelled = nullptr)
      : base_(base),
        cancelled_(cancelled),
        hierarchy_(base.hierarchy()),
        next_id_(next_id),
        deformations_(std::move(charge)) {}

  Status apply(const model::Update& update);

  /// Ends the draft, after the last update. Errors: kInvalidArgument if the hierarchy is too deep,
  /// or coordinates are beyond the range of doubles; those of Deformations::make().
  Status finish();

  /// Ids of PutNode's nodes, in order.
  const std::vector<model::NodeId>& put_nodes() const { return put_nodes_; }
  model::NodeId next_id() const { return next_id_; }

  /// Makes the revision after the base. Requires finish().
  std::shared_ptr<const Snapshot> publish(const MergeState& state) &&;

 private:
  Status put(const model::PutNode& put);
  Status set_transforms(const model::SetTransforms& set);
  Status remove(const model::DeleteNode& removal);
  Status patch(const model::PatchVertices& patch);

  Status check_cancelled() const;
  Result<model::NodeId> resolve(model::NodeRef ref) const;
  const model::Node* find(model::NodeId id) const;
  /// The node for editing: copied from the base the first time.
  model::Node& edit(model::NodeId id);
  void join(model::NodeId id, model::NodeId parent);
  void leave(model::NodeId id, model::NodeId parent);
  std::vector<model::NodeId> children_now(const model::Node& node) const;
  void update_children();
  Status deform();
  Status check_parent(model::NodeId node, model::NodeId parent) const;
  Status check_range() const;

  // The memory of the maps below, which is freed as a whole, not in a million pieces.
  std::pmr::monotonic_buffer_resource memory_;
  const Snapshot& base_;
  const std::atomic<bool>* const cancelled_;
  hierarchy::Hierarchy hierarchy_;  // that of the base, until finish()
  model::NodeId next_id_;
  std::pmr::unordered_map<model::NodeRef, model::NodeId> aliases_{&memory_};
  EditedNodes edited_{&memory_};
  /// The children that have come, or left, by parent; a child may come and leave several times.
  /// finish() changes each parent's list once.
  using Children = std::pmr::unordered_map<model::NodeId, std::pmr::vector<model::NodeId>>;
  Children joined_{&memory_}, left_{&memory_};
  MobilityChange change_;
  Deformations deformations_;
  std::vector<model::NodeId> put_nodes_;
};

}  // namespace sightline::scenegraph::revision
