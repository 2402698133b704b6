// The threads that work: the server's own oneTBB arena. RPC threads only hand tasks to it.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>

namespace sightline::server {

class Compute {
 public:
  /// `threads` workers (>= 1). No slot is kept for callers, so a thread that enqueues never works.
  explicit Compute(int threads);
  /// Waits for every task.
  ~Compute();

  /// Runs work() on a worker, first come first served. It must not throw. Parallel loops inside it
  /// stay in the arena. Threads: any.
  template <class Work>
  void enqueue(Work work) {
    begin();
    arena_.enqueue([this, task = new Work(std::move(work))] {
      std::unique_ptr<Work> owned(task);
      (*owned)();
      owned.reset();  // what the task holds may point into what is destroyed after this arena
      end();
    });
  }

  int threads() const { return threads_; }

 private:
  void begin();
  void end();

  const int threads_;
  // oneTBB keeps one of its threads for the main program, which here only waits for a signal.
  oneapi::tbb::global_control parallelism_;
  oneapi::tbb::task_arena arena_;
  std::mutex mutex_;
  std::condition_variable idle_;
  std::size_t pending_ = 0;
};

}  // namespace sightline::server
