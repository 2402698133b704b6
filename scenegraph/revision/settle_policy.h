// Records recent changes and tells when a new static tree is worth its cost.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// Nodes that stopped changing cost something at each revision while the dynamic tree holds them,
/// and so do removed nodes in the static tree. A new static tree costs as much as it has instances.
/// Rebuild when the accumulated cost exceeds that. Counts only; uses no clock. Threads: one at a
/// time.
class SettlePolicy {
 public:
  /// A node is static again after this many revisions without a change.
  static constexpr std::uint64_t kRevisions = 64;

  /// To be called for every revision with the nodes that it changed. Returns whether to rebuild.
  bool add(const Snapshot& snapshot, std::vector<model::NodeId> changed);

  /// A rebuild begins from this revision. Returns the recently changed nodes. Changes are kept
  /// until end().
  std::vector<model::NodeId> begin(std::uint64_t revision);
  /// The rebuild has ended. Returns the nodes changed after `revision`.
  std::vector<model::NodeId> end(std::uint64_t revision);

 private:
  struct Changes {
    std::uint64_t revision = 0;
    std::vector<model::NodeId> nodes;
  };

  std::vector<model::NodeId> changed_since(std::uint64_t revision) const;
  std::uint64_t misplaced_cost(const Snapshot& snapshot) const;

  std::deque<Changes> recent_;
  std::optional<std::uint64_t> rebuilding_;  // from this revision
  std::uint64_t spent_ = 0;
};

/// The same revision with `new_static` for its static tree. That tree was made at an earlier
/// revision, without `recently_changed`; `changed` are the nodes changed since then.
std::shared_ptr<const Snapshot> with_new_static(
    const Snapshot& now, const std::shared_ptr<const instances::SceneTree>& new_static,
    const std::vector<model::NodeId>& recently_changed, const std::vector<model::NodeId>& changed);

}  // namespace sightline::scenegraph::revision
