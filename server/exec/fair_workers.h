// Workers that run the jobs of a fair queue.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/exec/arena_priority.h"
#include "server/exec/fair_queue.h"

namespace sightline::server::exec {

struct WorkersOptions {
  int threads = 1;  ///< Workers (>= 1).
  /// A slice that runs for longer is long: it no longer counts as one of the workers.
  std::chrono::milliseconds long_after{50};
  Priority priority{};
  /// Whether the work is short: the workers then sleep while they have no slice. Workers of oneTBB
  /// look for work for some time before they sleep, and yield meanwhile. The system takes a yield
  /// as a time slice used, so on a busy machine they begin later.
  bool prompt = false;
};

/// Runs jobs slice by slice, in the order of a FairQueue. Parallel loops of a slice are helped by
/// workers that have no slice.
///
/// Not all work can be cut into short slices: the first ray of a large mesh reads all of it. When
/// all workers have been at their slices for long, as many others begin, in an arena of their own,
/// up to kArenas times; the system then divides the processors. So a build delays no other scene.
///
/// Threads: any, for every member.
class FairWorkers {
 public:
  static constexpr std::size_t kArenas = 4;

  explicit FairWorkers(const WorkersOptions& options);
  /// Waits until every job has ended.
  ~FairWorkers();

  /// Runs the job on workers, never in the calling thread. Throws std::bad_alloc; std::system_error
  /// if there is no thread and none can be made.
  void push(const FlowKey& key, Slice slice);

 private:
  class Arena;
  /// One turn on a worker.
  struct Running {
    FairQueue::Turn turn;
    Arena* arena = nullptr;
    std::chrono::steady_clock::time_point charged{};  // paid until here
    bool begun = false;                               // the system has given it a thread
    bool is_long = false;
  };
  using Position = std::list<Running>::iterator;

  void start_turns(std::size_t takers);
  void begin_turn(Arena& arena);
  void wake_for_turns(std::size_t takers);
  void work();
  void run_in_arena(Position position);
  void run(Position position);
  void watch();
  void charge(Running& running);

  const WorkersOptions options_;
  std::vector<std::unique_ptr<Arena>> arenas_;
  std::mutex mutex_;  // protects all members below
  std::condition_variable idle_, all_busy_, turns_;
  FairQueue queue_;
  std::list<Running> running_;
  std::deque<Position> begun_;  // turns that no thread of a prompt lane has taken
  std::size_t jobs_ = 0;        // waiting or running
  std::size_t short_ = 0;       // turns that are not long
  std::size_t asleep_ = 0;      // threads that wait for a turn
  bool stopping_ = false;
  std::vector<std::thread> threads_;
  std::thread watcher_;  // marks long turns
};

}  // namespace sightline::server::exec
