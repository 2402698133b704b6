// A scene with its recorded properties, history, write queue and events.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "scenegraph/scene.h"
#include "server/exec/executors.h"
#include "server/exec/memory_account.h"
#include "server/scenes/history.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/journal.h"
#include "server/scenes/names.h"
#include "server/scenes/past_revisions.h"
#include "server/scenes/scene_events.h"
#include "server/scenes/scene_follower.h"
#include "server/scenes/scene_info.h"
#include "server/scenes/update_log.h"
#include "server/scenes/write_line.h"

namespace sightline::server::scenes {

/// Updates of this many revisions stay in a scene's log when memory is short.
inline constexpr std::size_t kMinLogged = 4;

/// Who writes a batch, and who is told that it is kept.
struct SceneWrite {
  std::string request_id = {};       ///< Empty: none.
  std::uint64_t content = 0;         ///< Digest of the request.
  Producer* producer = nullptr;      ///< A producer of this scene. Null: none.
  std::uint64_t first_sequence = 0;  ///< The first of the producer's batches in this one.
  std::uint64_t batches = 1;
  /// Answers the write before it is committed. Not for scenes to which other servers write.
  bool relaxed = false;
  /// Called once, on the write queue, after the batch is published or dropped; perhaps before the
  /// write returns. May be empty.
  WriteLine::Answer answer = {};

  // Where other servers write to the scene and have committed first, the batch is applied again:
  // ApplyOptions::before_publish is called again, or one of these, before the write is answered.

  /// The batch of a producer is now invalid: it is recorded as rejected.
  std::function<void(const Error&)> rejected = {};
  /// The batch is kept, as another server has got it, too.
  std::function<void(const scenegraph::Applied& earlier)> repeated = {};
  int tries = 0;  ///< Tries so far.
};

/// A scene that clients can name. Must be made by std::make_shared. The members for writes may only
/// be used by tasks of write_queue(). Threads: any, for every other member.
class StoredScene : public std::enable_shared_from_this<StoredScene> {
 public:
  using Clock = std::chrono::steady_clock;

  /// What the scene holds is charged to `memory`, which outlives it.
  StoredScene(SceneInfo info, exec::MemoryAccount& memory, KeptScene kept = {});
  /// What readers still have is charged until they are gone.
  ~StoredScene();
  StoredScene(const StoredScene&) = delete;
  StoredScene& operator=(const StoredScene&) = delete;

  /// Reads the scene from its journal if it is not loaded. Other members but info(), token() and
  /// remove() may be used only after that. Waits for another thread that does the same. Errors: as
  /// Journal::load; after an error the scene cannot be used.
  Status load(exec::Compute& compute);
  bool loaded() const { return loaded_.load(std::memory_order_acquire); }
  /// Whether load() has failed.
  bool failed() const { return failed_.load(std::memory_order_acquire); }

  const SceneInfo& info() const { return info_; }
  /// How the scene is kept. Call it only while no write is being made: on a scene that is idle, or
  /// was not read.
  KeptScene kept() const;
  store::SceneId number() const { return number_; }
  /// The newest revision that is known of a scene that is not loaded. Threads: any.
  std::optional<std::uint64_t> unread() const;
  /// Null if no other server writes to the scene.
  SceneFollower* follower() { return follower_ ? &*follower_ : nullptr; }
  /// What keeps the scene beyond the process; null: nothing does.
  const std::shared_ptr<Journal>& journal() const { return journal_; }
  bool is_kept() const { return journal_ != nullptr; }
  RevisionToken token(std::uint64_t revision) const { return {incarnation_, revision}; }

  /// The newest revision.
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot() const {
    return scene_.snapshot();
  }
  /// The newest revision, and what the next batch needs beside it.
  scenegraph::SceneState state() const { return scene_.state(); }
  /// Errors: kOutOfRange, naming the oldest revision that is kept and the newest.
  Result<std::shared_ptr<const scenegraph::revision::Snapshot>> at(std::uint64_t revision) const;
  /// Summary of the newest revision. Walks the scene once per revision. Errors: as
  /// scenegraph::model::MeshSource::charge and read.
  Result<scenegraph::revision::SceneSummary> summary();

  exec::Strand& write_queue() { return write_queue_; }

  /// Applies a batch at the head. It is published, with its updates in the log and listeners
  /// called, before `write` is answered; without a journal, when this returns. Trees are
  /// merged later, on a background worker. Errors, after which nothing is answered: as
  /// Scene::apply and needed_by; kResourceExhausted where the memory budget has no room for it;
  /// kNotFound after remove(); kUnavailable while earlier writes cannot be stored. If memory runs
  /// out, nothing has changed. The answer is an error if the journal cannot keep the batch; it then
  /// had no effect. `options`: as for Scene::apply, but the scene itself charges for patches and
  /// publishes.
  Result<scenegraph::Applied> apply(std::vector<scenegraph::model::Update> updates,
                                    exec::Compute& compute,
                                    const scenegraph::ApplyOptions& options = {},
                                    const SceneWrite& write = {});
  /// Applies a batch as apply() does. `updates` are taken only if they are applied.
  Result<scenegraph::Applied> try_apply(std::vector<scenegraph::model::Update>& updates,
                                        exec::Compute& compute,
                                        const scenegraph::ApplyOptions& options,
                                        const SceneWrite& write);
  /// Records that a producer's batch was rejected: it counts, and makes no revision. Errors: as
  /// apply().
  Status record_rejected(exec::Compute& compute, const SceneWrite& write);
  using Repeat =
      std::function<void(const scenegraph::Applied& earlier, const Result<Durability>& kept)>;
  /// Whether a request of this id was applied before. If so, answer() is called with what it made
  /// when it is kept, perhaps before this returns. Errors: kInvalidArgument if it had another
  /// content.
  Result<bool> find_earlier(const std::string& request_id, std::uint64_t content,
                            const Repeat& answer);
  /// Calls then() when all writes so far are answered, perhaps now.
  void when_answered(std::function<void()> then);
  /// Calls then() when all writes so far are committed or answered with an error, perhaps now. An
  /// error: one that was acknowledged before is not committed.
  void when_committed(WriteLine::Committed then);
  Producers& producers() { return producers_; }

  /// Whether all that the scene holds is in its journal. Call it only while no task and no call has
  /// the scene.
  bool is_idle() const { return is_kept() && loaded() && !removed() && waiting() == 0; }

  /// Tries again to store writes that were acknowledged before, if there are any. Threads: any.
  void retry_writes();
  /// Waits until all writes so far are committed or answered with an error, at most until then.
  /// Threads: any that is no worker.
  void flush(Clock::time_point until);

  exec::MemoryAccount& memory() { return memory_; }

  const UpdateLog& log() const { return log_; }
  SceneEvents& events() { return events_; }

  /// Ends updates and calls the listeners.
  void remove();
  bool removed() const { return removed_.load(std::memory_order_acquire); }
  /// The error of calls after remove().
  Error removed_error() const;

  /// Notes that rays are cast at the scene now.
  void touch() { last_cast_.store(Clock::now(), std::memory_order_relaxed); }
  /// When touch() was called last; at first, when the scene was made.
  Clock::time_point last_cast() const { return last_cast_.load(std::memory_order_relaxed); }
  /// Bytes of the trees of the newest revision over its instances.
  std::uint64_t placed_tree_bytes() const;
  /// Drops the flat trees of the newest revision (Instances::drop_flat). Returns their bytes.
  std::uint64_t drop_flat_trees() const;
  /// The meshes that updates have made, and that are still used. Cost: their number.
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> patched_meshes() const;

  /// Drops all revisions except the newest, and with them the meshes that only they use.
  void drop_old_revisions();
  /// Revisions that only readers have.
  const PastRevisions& past() const { return past_; }
  /// Stops counting the revisions that have no reader any more.
  void release_gone();
  /// Drops all updates from the log but those of the newest kMinLogged revisions.
  void drop_old_updates();
  /// Calls Scene::drop_trees. Returns about the bytes of the old trees.
  std::uint64_t drop_trees();

 private:
  using PatchedMeshes = std::vector<std::weak_ptr<const scenegraph::model::Mesh>>;
  /// What an update has replaced.
  struct Dropped {
    std::vector<RecentRevisions::Kept> revisions;
    RecentRevisions::SnapshotPointer superseded, before;
  };
  struct Publication;
  class Loader;
  friend class SceneFollower;

  Status begin_write(exec::Compute& compute);
  Result<scenegraph::Applied> apply_at_head(std::vector<scenegraph::model::Update>& updates,
                                            const scenegraph::ApplyOptions& options,
                                            const SceneWrite& write, WriteLine* line);
  void reject_at_head(const SceneWrite& write);
  /// Applies a batch that the journal has.
  Result<scenegraph::Applied> replay(std::vector<scenegraph::model::Update> updates);
  /// Publishes what the journal has after the newest revision. Errors: as Journal::follow.
  Status read_on();
  /// Begins anew at what the journal has. Errors: as Journal::load.
  Status read_again();
  void set_progress(Producer& producer, KeptProducer kept);
  Status retry_after_conflict(const JournalEntry& entry, const scenegraph::ApplyOptions& options,
                              const SceneWrite& write, const WriteLine::Answer& answer);
  Result<bool> find_repeat(const SceneWrite& write, const WriteLine::Answer& answer);
  static JournalEntry entry_of(const SceneWrite& write, const scenegraph::Applied& next);
  WriteLine::Write line_write(JournalEntry entry, const scenegraph::ApplyOptions& options,
                              const SceneWrite& write,
                              const std::shared_ptr<Publication>& publication);
  void prepare_publication(Publication& publication, const SceneWrite& write,
                           const scenegraph::Applied& next,
                           std::vector<scenegraph::model::Update>& updates);
  void prepare_producer(Publication& publication, const SceneWrite& write,
                        const scenegraph::Applied& next);
  // NOLINTNEXTLINE(bugprone-exception-escape): as its definition
  void finish_write(WriteLine* line, WriteLine::Prepared item, Publication& publication,
                    const SceneWrite& write) noexcept;
  // NOLINTNEXTLINE(bugprone-exception-escape): as its definition
  void publish(Publication& publication) noexcept;
  void advance_soon() noexcept;
  /// Writes that are not published.
  std::size_t waiting() const { return line_ ? line_->size() : 0; }

  Result<std::shared_ptr<const void>> charge_patch(std::uint64_t bytes);
  void reserve_patched(const std::vector<scenegraph::model::Update>& updates);
  void remember_patched(const std::vector<scenegraph::model::Update>& updates);
  void forget(std::vector<RecentRevisions::Kept>& kept) noexcept;
  void clean_up_later(Dropped dropped, bool merge_trees) noexcept;
  /// When it returns, nothing that was dropped before the call is held any more.
  void free_dropped();

  exec::MemoryAccount& memory_;
  const SceneInfo info_;
  const std::uint64_t incarnation_;
  const store::SceneId number_;
  const std::shared_ptr<Journal> journal_;
  std::optional<SceneFollower> follower_;         // where other servers write to the journal
  std::optional<WriteLine> line_;                 // with a journal; used on the write queue
  std::atomic<bool> advance_posted_{false};       // whether a task will advance the line
  std::atomic<exec::Compute*> compute_{nullptr};  // null before the first write or reading
  std::uint64_t name_bytes_ = 0;                  // in the newest revision; used on the write queue
  exec::MemoryAccount::Charge nodes_;             // in the newest revision; used on the write queue
  mutable std::mutex patched_mutex_;
  mutable PatchedMeshes patched_;  // meshes that updates have made, of any revision
  std::atomic<Clock::time_point> last_cast_{Clock::now()};
  PastRevisions past_{memory_};  // goes after all owners of revisions that are below
  scenegraph::Scene scene_;
  RecentRevisions recent_;
  UpdateLog log_{memory_};
  SceneEvents events_;
  std::atomic<bool> removed_{false};
  std::mutex loading_;  // held while the scene is loaded
  Status read_;         // the reason, if that failed; protected by loading_
  const std::optional<std::uint64_t> unread_;
  const std::uint64_t unread_bytes_;  // what its nodes will take at least
  std::atomic<bool> loaded_, failed_{false};
  std::mutex freeing_mutex_;  // held while memory is freed
  std::mutex dropped_mutex_;  // protects the next
  std::vector<Dropped> dropped_;
  exec::Strand write_queue_;
  RequestAnswers answers_{memory_};
  Producers producers_{memory_};
  std::mutex summary_mutex_;
  std::optional<std::uint64_t> summarized_revision_;
  scenegraph::revision::SceneSummary summary_;
};

/// Errors: kNotFound.
Error unknown_scene(const std::string& name);

}  // namespace sightline::server::scenes
