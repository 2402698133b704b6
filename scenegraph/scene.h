// A scene: its current snapshot, and the one writer that makes the next.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "accel/result.h"
#include "scenegraph/snapshot.h"
#include "scenegraph/update.h"

namespace sightline::scenegraph {

/// What a batch of updates came to.
struct Applied {
  std::uint64_t revision = 0;
  std::vector<NodeId> nodes;  ///< The id of every PutNode's node, in the order of the batch.
};

class Scene {
 public:
  Scene();

  /// The newest revision. Never waits for a writer. Threads: any.
  std::shared_ptr<const Snapshot> snapshot() const;

  /// Applies the batch whole, or leaves the scene as it was. Threads: any; writers take turns.
  /// `expected_revision`: refuse (kAborted) unless this is the current revision.
  /// Errors name the update's place in the batch: kNotFound (unknown node or parent),
  /// kInvalidArgument (cycle, singular or non-finite matrix, name too long, depth over kMaxDepth,
  /// counts that disagree), kFailedPrecondition (delete of a node with children).
  Result<Applied> apply(const std::vector<Update>& updates,
                        std::optional<std::uint64_t> expected_revision = std::nullopt);

 private:
  std::mutex writer_;
  mutable std::mutex current_mutex_;  // held for one pointer copy
  std::shared_ptr<const Snapshot> current_;
  NodeId next_id_ = 1;
};

}  // namespace sightline::scenegraph
