// A scene with its recorded properties, history, write queue and events.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
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
#include "server/scenes/names.h"

namespace sightline::server::scenes {

/// Listeners of one scene. notify() is called after a new revision, after another call takes over a
/// producer, and after the removal of the scene. The listener checks the scene to find out which.
/// Threads: any, for every member.
class SceneEvents {
 public:
  using Listener = std::function<void()>;

  /// `listener` must be short and must call neither subscribe() nor unsubscribe(). What it throws
  /// is logged.
  std::uint64_t subscribe(Listener listener);
  /// When this returns, the listener is not running and will not be called.
  void unsubscribe(std::uint64_t id);
  void notify() noexcept;

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, Listener> listeners_;
  std::uint64_t next_ = 1;
};

enum class UpAxis : std::uint8_t { kUnspecified, kY, kZ };

/// What a scene was created with. The axis and the unit are recorded as given; no value is
/// converted with them.
struct SceneInfo {
  std::string name;  ///< Resource name.
  UpAxis up_axis = UpAxis::kUnspecified;
  double meters_per_unit = 0;  ///< 0: unknown.
};

/// Updates of this many revisions stay in a scene's log when memory is short.
inline constexpr std::size_t kMinLogged = 4;

/// A scene that clients can name. Must be made by std::make_shared. apply(), answers() and
/// producers() may only be used by tasks of write_queue(). Threads: any, for every other member.
class StoredScene : public std::enable_shared_from_this<StoredScene> {
 public:
  using Clock = std::chrono::steady_clock;

  /// What the scene holds is charged to `memory`, which outlives it.
  StoredScene(SceneInfo info, exec::MemoryAccount& memory);

  const SceneInfo& info() const { return info_; }
  RevisionToken token(std::uint64_t revision) const { return {incarnation_, revision}; }

  /// The newest revision.
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot() const {
    return scene_.snapshot();
  }
  /// Errors: kOutOfRange, naming the oldest revision that is kept and the newest.
  Result<std::shared_ptr<const scenegraph::revision::Snapshot>> at(std::uint64_t revision) const;
  /// Summary of the newest revision. Walks the scene once per revision.
  scenegraph::revision::SceneSummary summary();

  exec::Strand& write_queue() { return write_queue_; }
  /// Applies a batch. When it returns, the new revision is in the log and listeners have been
  /// called. The static tree is settled later, on a background worker. Errors: as Scene::apply and
  /// needed_by; kResourceExhausted where the memory budget has no room for it; kNotFound after
  /// remove(). If memory runs out, nothing has changed.
  /// `options`: as for Scene::apply, but the scene itself charges for patches.
  Result<scenegraph::Applied> apply(std::vector<scenegraph::model::Update> updates,
                                    exec::Compute& compute,
                                    const scenegraph::ApplyOptions& options = {});
  RequestAnswers& answers() { return answers_; }
  Producers& producers() { return producers_; }

  exec::MemoryAccount& memory() { return memory_; }

  const UpdateLog& log() const { return log_; }
  SceneEvents& events() { return events_; }

  /// Ends updates and calls the listeners.
  void remove();
  bool removed() const { return removed_.load(std::memory_order_acquire); }
  /// The error of calls after remove().
  Error removed_error() const;

  /// Rays are cast at the scene now.
  void touch() { last_cast_.store(Clock::now(), std::memory_order_relaxed); }
  /// When touch() was called last; at first, when the scene was made.
  Clock::time_point last_cast() const { return last_cast_.load(std::memory_order_relaxed); }
  /// Bytes of the trees of the newest revision, without those of uploaded meshes. Cost: the number
  /// of meshes that updates have made.
  std::uint64_t tree_bytes() const;

  /// Drops all revisions except the newest, and with them the meshes that only they use.
  void drop_old_revisions();
  /// Drops all updates from the log but those of the newest kMinLogged revisions.
  void drop_old_updates();
  /// As Scene::drop_trees. Returns about the bytes of the old trees.
  std::uint64_t drop_trees();

 private:
  using PatchedMeshes = std::vector<std::weak_ptr<const scenegraph::model::Mesh>>;
  /// What an update has replaced.
  struct Dropped {
    std::vector<RecentRevisions::Kept> revisions;
    RecentRevisions::SnapshotPointer unsettled, before;
  };
  Result<std::shared_ptr<const void>> charge_patch(std::uint64_t bytes);
  void reserve_patched(const std::vector<scenegraph::model::Update>& updates);
  void remember_patched(const std::vector<scenegraph::model::Update>& updates);
  void settle_later(Dropped dropped, bool settle, exec::Compute& compute) noexcept;
  /// When it returns, nothing that was dropped before the call is held any more.
  void free_dropped();

  exec::MemoryAccount& memory_;
  const SceneInfo info_;
  const std::uint64_t incarnation_ = new_incarnation();
  std::uint64_t name_bytes_ = 0;       // of the newest revision; used on the write queue
  exec::MemoryAccount::Charge nodes_;  // of the newest revision; used on the write queue
  mutable std::mutex patched_mutex_;
  mutable PatchedMeshes patched_;  // meshes that updates have made, of any revision
  std::atomic<Clock::time_point> last_cast_{Clock::now()};
  scenegraph::Scene scene_;
  RecentRevisions recent_;
  UpdateLog log_{memory_};
  SceneEvents events_;
  std::atomic<bool> removed_{false};
  std::mutex freeing_mutex_;  // held while memory is freed
  std::mutex dropped_mutex_;  // protects the next
  std::vector<Dropped> dropped_;
  exec::Strand write_queue_;
  RequestAnswers answers_{memory_};
  Producers producers_;
  std::mutex summary_mutex_;
  std::optional<std::uint64_t> summarized_revision_;
  scenegraph::revision::SceneSummary summary_;
};

/// Errors: kNotFound.
Error unknown_scene(const std::string& name);

}  // namespace sightline::server::scenes
