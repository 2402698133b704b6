// The threads that work: the server's own oneTBB arenas. RPC threads only hand tasks to them.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>

namespace sightline::server::exec {

class Compute {
 public:
  /// `threads` workers (>= 1), as many for updates, and as many apart. No slot is kept for callers,
  /// so a thread that enqueues never works.
  explicit Compute(int threads);
  /// Waits for every task.
  ~Compute();

  /// Runs work() on a worker, first come first served. It must not throw. Parallel loops inside it
  /// stay in the arena. Threads: any.
  template <class Work>
  void enqueue(Work work) {
    enqueue_in(arena_, std::move(work));
  }

  /// The same, on the workers that are apart: for work that takes long and that no answer waits
  /// for. It takes no worker from enqueue(), only a share of the processors while both are busy.
  template <class Work>
  void enqueue_background(Work work) {
    enqueue_in(background_, std::move(work));
  }

  /// The same, on the workers for updates: for work that is short and does not wait behind queries.
  template <class Work>
  void enqueue_update(Work work) {
    enqueue_in(updates_, std::move(work));
  }

  int threads() const { return threads_; }

 private:
  template <class Work>
  void enqueue_in(oneapi::tbb::task_arena& arena, Work work) {
    begin();
    arena.enqueue([this, task = new Work(std::move(work))] {
      std::unique_ptr<Work> owned(task);
      (*owned)();
      owned.reset();  // what the task holds may point into what is destroyed after this arena
      end();
    });
  }

  void begin();
  void end();

  const int threads_;
  // oneTBB keeps one of its threads for the main program, which here only waits for a signal.
  oneapi::tbb::global_control parallelism_;
  oneapi::tbb::task_arena arena_, updates_, background_;
  std::mutex mutex_;
  std::condition_variable idle_;
  std::size_t pending_ = 0;
};

}  // namespace sightline::server::exec
