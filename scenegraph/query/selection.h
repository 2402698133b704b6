// The part of a scene that a query sees: the nodes under one root, without those under others, of
// these the ones that their labels let through, and of these the ones in one shard.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "proto/result.h"
#include "scenegraph/instances/instance_filter.h"
#include "scenegraph/query/label_filter.h"
#include "scenegraph/query/shard_cut.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::query {

/// Checks that this revision has these nodes. Errors: kNotFound, naming the role and the first id
/// of which it has no node.
Status check_nodes(const revision::Snapshot& snapshot, std::span<const model::NodeId> ids,
                   const char* role);

/// The instances that a query sees. Each one is decided when a ray first meets its box, by looking
/// up the hierarchy. Making a selection takes no time in proportion to the scene. Threads: any.
class Selection {
 public:
  /// Selects `root` and all nodes under it (0: the whole scene), without each node of `excluded`
  /// and all under it; of these, the instances that `labels` sees and that are in `shard`, which
  /// is a cut of the snapshot. Keeps the snapshot, which must be the one that is traced. Errors:
  /// kNotFound, naming the id that is no node of this revision.
  static Result<Selection> make(std::shared_ptr<const revision::Snapshot> snapshot,
                                model::NodeId root, std::span<const model::NodeId> excluded,
                                LabelFilter labels = {}, Shard shard = {});

  /// Whether the query sees an opened instance. `index` is that of Snapshot::trees().
  bool selects(std::size_t index) const {
    return selected_.passes(index, [&] { return decide(index); });
  }

 private:
  Selection(std::shared_ptr<const revision::Snapshot> snapshot, model::NodeId root,
            std::vector<model::NodeId> excluded, LabelFilter labels, Shard shard);
  bool decide(std::size_t index) const;

  std::shared_ptr<const revision::Snapshot> snapshot_;
  model::NodeId root_;
  std::vector<model::NodeId> excluded_;  // ascending
  LabelView labels_;
  Shard shard_;
  instances::OpenTrees trees_;  // of the snapshot
  instances::InstanceFilter selected_;
};

}  // namespace sightline::scenegraph::query
