// The one thread that writes to a database: it commits what waits together.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "proto/result.h"
#include "server/store/engine.h"
#include "server/store/limits.h"

namespace sightline::server::store {

/// Figures of the commits so far.
struct WriterFigures {
  std::uint64_t commits = 0;
  std::uint64_t batches = 0;  ///< Batches queued by submit(), in these commits.
  std::uint64_t failures = 0;
  std::chrono::nanoseconds commit_time{0};
  std::uint64_t in_flight = 0;
  std::uint64_t bytes_in_flight = 0;
};

/// Threads: any, for every member.
class Writer {
 public:
  using Run = std::function<Status(Database&)>;
  using Done = std::function<void(const Status&)>;

  /// `limits` outlives this object.
  Writer(std::unique_ptr<Engine> engine, const StoreLimits& limits);
  /// Commits what is queued first.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Queues work that changes a scene and writes about `bytes`; `run` is called in a transaction,
  /// once or, if that was undone, again. If it fails, what it wrote is undone. `done` is called on
  /// the writer's thread once the transaction is on disk, or has failed. Errors:
  /// kResourceExhausted, and then nothing is queued.
  Status submit(SceneId scene, Run run, Done done, std::uint64_t bytes);

  /// Queues work that frees disk, or writes little, without limits, and waits for it. Must not be
  /// called on the writer's thread. `scene`: 0 if it changes none that exists.
  Status perform(SceneId scene, const Run& run);

  /// Waits until all that was queued before is done.
  void flush();

  /// What the last transaction ended with.
  Status last() const;
  WriterFigures figures() const;

  /// Rows may have become garbage, which is purged from now on.
  void expect_garbage();

 private:
  struct Work {
    Run run;
    Done done;
    std::uint64_t bytes = 0;
    SceneId scene = 0;
    bool limited = false;
    Status status;
    bool ended = false;  // has failed, and is not run again
  };
  using Group = std::vector<Work>;

  void loop();
  Group next_group();
  void gather(std::unique_lock<std::mutex>& lock);
  void commit(Group& group);
  Status transact(Group& group);
  Status transact_once(Group& group, bool& committed);
  Status run_all(Group& group);
  Status run_one(Work& work);
  Status run_isolated(Work& work);
  void refuse_growth(Group& group);
  void purge();
  void finish(Group& group, const Status& outcome, std::chrono::nanoseconds took);

  const std::unique_ptr<Engine> engine_;  // used by the thread
  const StoreLimits& limits_;
  std::size_t last_group_ = 0;  // used by the thread, as the next
  bool isolated_ = true;        // each piece of work has a savepoint
  bool tight_ = false;          // the disk had no space for the last group
  std::atomic<bool> garbage_{false};

  mutable std::mutex mutex_;  // protects the rest
  std::condition_variable queued_;
  std::condition_variable idle_;
  std::deque<Work> queue_;
  std::uint64_t entered_ = 0;  // work that was queued so far
  std::uint64_t left_ = 0;     // work that is done
  WriterFigures figures_;
  Status last_;
  bool ending_ = false;
  std::thread thread_;  // begins last
};

}  // namespace sightline::server::store
