// A scene: its current snapshot, and the one writer that makes the next.
//
// What a revision changes is in a dynamic tree of its own, or in one with changes of revisions
// before; the static tree holds the rest, and trees are kept as long as they are large. A node
// begins in the tree that its mobility says. After rays have opened the static tree, a changed node
// moves to the newest dynamic tree, and merge_trees() makes larger trees of nodes that rest.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/levels.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph {

/// The result of a batch of updates.
struct Applied {
  std::uint64_t revision = 0;
  std::vector<model::NodeId> nodes;  ///< The id of every PutNode's node, in the order of the batch.
  bool merge_trees = false;          ///< Scene::merge_trees() is worth its cost now.
};

struct ApplyOptions {
  /// If set, the batch is refused (kAborted) unless this is the current revision.
  std::optional<std::uint64_t> expected_revision = std::nullopt;
  /// Called with the result when nothing else can fail any more. If it throws, the scene is as it
  /// was.
  std::function<void(const Applied&)> before_publish = {};
  /// Called with the bytes of each mesh that the patches make, before it is made; the charge lives
  /// as long as that mesh.
  model::ChargeBytes charge = {};
  /// Once it is true, the batch soon ends with kCancelled and is not applied. Null: never.
  const std::atomic<bool>* cancelled = nullptr;
  /// Whether readers see the revision at once. If not, publish_next() shows it later.
  bool publish = true;
};

/// A scene as it is written down: all nodes at one revision.
struct SceneContent {
  std::uint64_t revision = 0;
  model::NodeId next_id = 1;
  /// The nodes, each after its parent; children of one parent in their order. `children`, `entered`
  /// and `is_flat` are not used.
  std::vector<model::Node> nodes;
};

/// A revision, and the node id that the next new node gets.
struct SceneState {
  std::shared_ptr<const revision::Snapshot> snapshot;
  model::NodeId next_id = 1;
};

class Scene {
 public:
  explicit Scene(const revision::MergeRule& rule = {});

  /// Begins anew at this revision. No revision may wait for publish_next(). Errors: kDataLoss, if
  /// the content is not that of a scene. Threads: any; no writer meanwhile.
  Status restore(SceneContent content);

  /// The newest published revision. Never waits for a writer. Threads: any.
  std::shared_ptr<const revision::Snapshot> snapshot() const { return state().snapshot; }
  SceneState state() const;
  /// The newest revision that was applied: what the next batch changes. Waits for a writer.
  std::shared_ptr<const revision::Snapshot> head() const;

  /// Applies the whole batch to the head, or leaves the scene as it was. Threads: any; one writer
  /// at a time. Where there are revisions that wait for publish_next(), `publish` must be false.
  /// Errors name the update's index in the batch: kNotFound (unknown node or parent),
  /// kInvalidArgument (cycle, non-finite matrix, name too long, labels beyond their limits, depth
  /// over kMaxDepth, counts that disagree), kFailedPrecondition (delete of a node with children),
  /// kCancelled, and those of the charge.
  Result<Applied> apply(const std::vector<model::Update>& updates,
                        const ApplyOptions& options = {});

  /// Publishes the oldest revision that is not published; there must be one. Threads: any.
  void publish_next() noexcept;
  /// Drops all revisions that are not published: the head is snapshot() again. Threads: any.
  void drop_unpublished() noexcept;

  /// Makes one tree of neighbouring trees of the current revision (revision::due_static_merge,
  /// revision::due_dynamic_merge) and grows it where they were grown. Writers and readers continue
  /// meanwhile. Then publishes the current revision again, under the same number, since its content
  /// is the same. Does nothing if another thread does the same, if no merge is due, or if those
  /// trees are replaced meanwhile. A dynamic tree may be made while another thread makes a static
  /// one. Threads: any.
  void merge_trees();

  /// Begins new trees, of the scene and of its meshes, and publishes the current revision again:
  /// its content is the same. The old trees are freed when no batch of rays uses them. Returns the
  /// bytes of the old trees of meshes. Cost: one walk of the nodes. Throws std::bad_alloc; some
  /// trees may then be dropped. Threads: any.
  std::uint64_t drop_trees();

 private:
  SceneState newest() const { return unpublished_.empty() ? state() : unpublished_.back(); }
  void set_published(SceneState next) noexcept;
  template <class Renew>
  void renew_trees(const Renew& renew);
  template <class Due>
  void merge(std::mutex& merging, std::uint64_t& up_to, const Due& due);
  std::optional<revision::LevelRange> due_static_merge(const revision::Snapshot& now) const;
  std::optional<revision::LevelRange> due_dynamic_merge(const revision::Snapshot& now) const;

  mutable std::mutex writer_;
  std::deque<SceneState> unpublished_;  // guarded by writer_; oldest first
  std::mutex static_merging_, dynamic_merging_;
  revision::MergeState merge_state_;    // guarded by writer_
  mutable std::mutex published_mutex_;  // held for one copy
  SceneState published_;
};

}  // namespace sightline::scenegraph
