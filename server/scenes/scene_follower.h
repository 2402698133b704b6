// Keeps a scene up to date with what other servers commit to it.
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

#include "proto/result.h"
#include "server/exec/executors.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/journal.h"
#include "server/scenes/replica.h"

namespace sightline::server::scenes {

class StoredScene;

/// How often a write that conflicts with those of other servers is tried before it fails.
inline constexpr int kMaxTries = 32;

/// How far a scene is behind what is known to be committed.
struct Lag {
  std::uint64_t revisions = 0;
  std::chrono::steady_clock::duration time{0};
};

/// A part of a scene, which reads what others have committed while no write of this server waits.
/// The commit of a waiting write shows whether there is anything to read.
class SceneFollower {
 public:
  using Clock = std::chrono::steady_clock;
  using Then = std::function<void(const Status&)>;

  /// `scene` owns this object.
  SceneFollower(StoredScene& scene, std::shared_ptr<Replica> replica)
      : scene_(scene), replica_(std::move(replica)) {}

  Replica& replica() const { return *replica_; }
  const std::shared_ptr<Replica>& shared_replica() const { return replica_; }

  // Threads: any.

  /// The journal has this revision. If the scene is loaded and has it not, it is read soon.
  void note(std::uint64_t revision, exec::Compute& compute);
  /// Reads what others have committed, unless that is about to happen. Returns at once.
  void follow_soon(exec::Compute& compute);
  /// Calls then() on the write queue when all that was committed before the call is published.
  void ask(exec::Compute& compute, Then then);
  /// The newest revision that note() was told; 0: none.
  std::uint64_t noted() const { return noted_.load(std::memory_order_relaxed); }
  Lag lag() const;

  // Used on the write queue.

  /// Publishes what others have committed. No write may wait. Errors: as Journal::follow, but for
  /// kOutOfRange.
  Status catch_up();
  /// Calls then() when all that was committed before the call is published, perhaps now. Errors:
  /// as catch_up().
  void when_caught_up(exec::Compute& compute, Then then);
  /// Reads what is kept of a request, so that StoredScene::find_earlier() knows it.
  Status look_up(const std::string& request_id);
  /// Reads the progress of a producer, which has no waiting write, when all that was committed
  /// before the call is published. Then calls then(). Errors: as catch_up().
  void look_up(Producer& producer, exec::Compute& compute, Then then);
  /// If these batches of a producer are kept, the ids of the nodes that the last of them put;
  /// nothing if none is kept. Errors: kUnavailable also if only some are.
  Result<std::optional<std::vector<scenegraph::model::NodeId>>> find_kept(
      const std::string& producer, std::uint64_t first_sequence, std::uint64_t batches);

 private:
  friend class StoredScene;
  Status look_up(Producer& producer);
  void wait(exec::Compute& compute, Then then, int rounds);
  Status read_on();
  void log(const Status& read);

  StoredScene& scene_;
  const std::shared_ptr<Replica> replica_;
  std::atomic<std::uint64_t> noted_{0};
  std::atomic<bool> following_{false};  // a task is posted, or waits for writes
  bool failed_ = false;                 // the last time; used on the write queue
  mutable std::mutex mutex_;
  Clock::time_point behind_since_;  // protected by mutex_; meaningful while it is behind
};

}  // namespace sightline::server::scenes
