// Worker threads: the server's oneTBB arenas, and strands of tasks that run one after the other.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace sightline::server::exec {

/// Worker threads in five arenas: queries, small queries, updates, management, background. An arena
/// that is busy delays no other: the system divides the processors among them. RPC threads only
/// enqueue tasks.
class Compute {
 public:
  /// Each arena has `threads` workers (>= 1) and no slot for callers, so a thread that enqueues
  /// never runs tasks.
  explicit Compute(int threads);
  /// Waits until every task has ended.
  ~Compute();

  /// Runs work() on a worker for queries, in order of arrival. It must not throw. Its parallel
  /// loops stay in the arena. Threads: any.
  template <class Work>
  void enqueue(Work work) {
    enqueue_in(arena_, std::move(work));
  }

  /// As enqueue(), on a worker for queries of few rays, which must not queue behind large ones.
  template <class Work>
  void enqueue_small(Work work) {
    enqueue_in(small_, std::move(work));
  }

  /// As enqueue(), on a worker for management: short work, such as reading a scene's properties.
  template <class Work>
  void enqueue_management(Work work) {
    enqueue_in(management_, std::move(work));
  }

  /// As enqueue(), on a background worker: for long work that no answer waits for. It occupies no
  /// worker of enqueue(), but shares the processors with them.
  template <class Work>
  void enqueue_background(Work work) {
    enqueue_in(background_, std::move(work));
  }

  /// As enqueue(), on a worker for updates: for short work that must not queue behind queries.
  template <class Work>
  void enqueue_update(Work work) {
    enqueue_in(updates_, std::move(work));
  }

  int threads() const { return threads_; }

 private:
  template <class Work>
  void enqueue_in(oneapi::tbb::task_arena& arena, Work work) {
    auto task = std::make_unique<Work>(std::move(work));
    begin();
    try {
      arena.enqueue([this, task = task.get()] {
        std::unique_ptr<Work> owned(task);
        (*owned)();
        owned.reset();  // end() may let ~Compute() return, and the task may refer to objects
                        // destroyed after it
        end();
      });
    } catch (...) {
      end();
      throw;
    }
    static_cast<void>(task.release());
  }

  void begin();
  void end();

  const int threads_;
  // oneTBB counts the main thread too, which here only waits for a signal.
  oneapi::tbb::global_control parallelism_;
  oneapi::tbb::task_arena arena_, small_, updates_, management_, background_;
  std::mutex mutex_;
  std::condition_variable idle_;
  std::size_t pending_ = 0;
};

/// Runs tasks one after the other on the workers for updates. No worker waits for another task, as
/// it would for a lock. After each task the worker takes the next one in the arena, which may be of
/// another strand. A task may own the strand it runs on.
class Strand {
 public:
  /// Runs task() after all tasks posted before. It must not throw. Threads: any.
  void post(Compute& compute, std::function<void()> task);

 private:
  struct State {
    std::mutex mutex;
    std::deque<std::function<void()>> tasks;
    bool running = false;
  };
  static void run_next(Compute& compute, std::shared_ptr<State> state);

  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace sightline::server::exec
