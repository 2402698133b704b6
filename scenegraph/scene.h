// A scene: its current snapshot, and the one writer that makes the next.
//
// What moves is in the dynamic tree, which is made anew for each revision; what rests is in the
// static one, which lives on. Mobility is where a node begins. Once rays have looked, a node that
// changes joins the dynamic tree, and settle() brings back those that rest.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/settle_policy.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph {

/// What a batch of updates came to.
struct Applied {
  std::uint64_t revision = 0;
  std::vector<model::NodeId> nodes;  ///< The id of every PutNode's node, in the order of the batch.
  bool settle = false;               ///< Enough rests in the dynamic tree for Scene::settle().
};

class Scene {
 public:
  Scene();

  /// The newest revision. Never waits for a writer. Threads: any.
  std::shared_ptr<const revision::Snapshot> snapshot() const;

  /// Applies the batch whole, or leaves the scene as it was. Threads: any; writers take turns.
  /// `expected_revision`: refuse (kAborted) unless this is the current revision.
  /// Errors name the update's place in the batch: kNotFound (unknown node or parent),
  /// kInvalidArgument (cycle, singular or non-finite matrix, name too long, depth over kMaxDepth,
  /// counts that disagree), kFailedPrecondition (delete of a node with children).
  Result<Applied> apply(const std::vector<model::Update>& updates,
                        std::optional<std::uint64_t> expected_revision = std::nullopt);

  /// Takes what has rested for Rest::kRevisions out of the dynamic tree and into a static tree made
  /// anew, in the background: writers and readers go on meanwhile. Then publishes the current
  /// revision once more, by the same number, for it says the same. Does nothing while another
  /// thread is at it, and where rays have not looked yet. Threads: any.
  void settle();

 private:
  void publish(std::shared_ptr<const revision::Snapshot> next);

  std::mutex writer_;
  revision::Rest rest_;  // the writer's
  std::mutex settling_;
  mutable std::mutex current_mutex_;  // held for one pointer copy
  std::shared_ptr<const revision::Snapshot> current_;
  model::NodeId next_id_ = 1;
};

}  // namespace sightline::scenegraph
