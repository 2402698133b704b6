// What has changed of late, and whether enough of the dynamic tree rests for it to settle.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// Counts, never clocks: what rests in the dynamic tree, and what has departed from the static one,
/// costs something at each revision; a static tree made anew costs as much as it has instances.
/// Once the one comes to the other, it is worth its while. Threads: one at a time.
class Rest {
 public:
  /// What has not changed for so many revisions rests.
  static constexpr std::uint64_t kRevisions = 64;

  /// To be told of every revision: the nodes changed by it. Returns whether it is time to settle.
  bool add(const Snapshot& snapshot, std::vector<model::NodeId> changed);

  /// Settling begins, from this revision: what does not rest. Until end(), changes are kept.
  std::vector<model::NodeId> begin(std::uint64_t revision);
  /// It has ended: what has changed meanwhile.
  std::vector<model::NodeId> end(std::uint64_t revision);

 private:
  struct Changes {
    std::uint64_t revision = 0;
    std::vector<model::NodeId> nodes;
  };

  std::vector<model::NodeId> since(std::uint64_t revision) const;
  std::uint64_t at_rest(const Snapshot& snapshot) const;

  std::deque<Changes> recent_;
  std::optional<std::uint64_t> settling_;  // since this revision
  std::uint64_t spent_ = 0;
};

/// The revision once more, with `settled` for its static half. That was made at an earlier
/// revision, without `restless`; `changed` are the nodes that have changed since.
std::shared_ptr<const Snapshot> resettled(
    const Snapshot& now, const std::shared_ptr<const instances::SceneHalf>& settled,
    const std::vector<model::NodeId>& restless, const std::vector<model::NodeId>& changed);

}  // namespace sightline::scenegraph::revision
