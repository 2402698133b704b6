// Worker threads for each kind of work, and strands of tasks that run one after the other.
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

#include "server/exec/caller.h"
#include "server/exec/fair_workers.h"

namespace sightline::server::exec {

/// The flow of a caller's work at `scene`. Empty: the work is for no scene.
inline FlowKey flow_of(const Caller& caller, std::string scene = {}) {
  return {caller.principal, caller.connection, std::move(scene)};
}

/// Worker threads for five kinds of work: queries, small queries, background work, updates and
/// management. No kind delays another: the system divides the processors among them. RPC threads
/// only enqueue.
class Compute {
 public:
  /// Each kind has `threads` workers (>= 1). A thread that enqueues never runs tasks.
  explicit Compute(int threads);
  /// Waits until every task has ended.
  ~Compute();

  /// Runs the job on workers for queries, slice by slice and in turn with those of other clients
  /// and scenes. Parallel loops use the same workers. Threads: any.
  void enqueue(const FlowKey& key, Slice slice) { push(queries_, key, std::move(slice)); }

  /// Runs other work() of a caller, such as a part of an upload, on workers for queries. It must
  /// not throw.
  template <class Work>
  void enqueue_work(const Caller& caller, Work work) {
    push(queries_, flow_of(caller), job_of(std::move(work)));
  }

  /// Runs the job on workers for queries of few rays.
  void enqueue_small(const FlowKey& key, Slice slice) { push(small_, key, std::move(slice)); }

  /// Runs the job on background workers: for long work such as full builds. Beside other workers
  /// they get little of the processors.
  void enqueue_background(const FlowKey& key, Slice slice) {
    push(background_, key, std::move(slice));
  }

  /// Runs the server's own work() on a background worker. It must not throw.
  template <class Work>
  void enqueue_background(Work work) {
    push(background_, {}, job_of(std::move(work)));
  }

  /// Runs work() on a worker for management, in order of arrival: short work, such as reading a
  /// scene's properties. It must not throw. Threads: any.
  template <class Work>
  void enqueue_management(Work work) {
    enqueue_in(management_, std::move(work));
  }

  /// Runs work() on a worker for updates, in turn with those of other callers and scenes. What
  /// takes long, such as reading a scene, delays no other. It must not throw. Threads: any.
  template <class Work>
  void enqueue_update(const FlowKey& key, Work work) {
    push(updates_, key, job_of(std::move(work)));
  }

  int threads() const { return threads_; }

 private:
  template <class Work>
  static Slice job_of(Work work) {
    return [work = std::make_shared<Work>(std::move(work))] {
      (*work)();
      return false;
    };
  }

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

  void push(FairWorkers& workers, const FlowKey& key, Slice slice);
  void begin();
  void end();

  const int threads_;
  // oneTBB counts the main thread too, which here only waits for a signal.
  oneapi::tbb::global_control parallelism_;
  oneapi::tbb::task_arena management_;
  FairWorkers updates_, background_, queries_, small_;
  std::mutex mutex_;
  std::condition_variable idle_;
  std::size_t pending_ = 0;  // tasks of every kind: one may enqueue others
};

/// Runs tasks one after the other on the workers for updates. No worker waits for another task, as
/// it would for a lock. After each task the worker takes the next one in the arena, which may be of
/// another strand. A task may own the strand it runs on.
class Strand {
 public:
  /// `key`: the flow of its tasks.
  explicit Strand(FlowKey key = {}) : state_(std::make_shared<State>(std::move(key))) {}

  /// Runs task() after all tasks posted before. It must not throw. Threads: any.
  void post(Compute& compute, std::function<void()> task);

  /// Runs task() in the calling thread, before it returns, if no other task runs or waits; else
  /// does as post().
  void run_or_post(Compute& compute, std::function<void()> task);

 private:
  struct State {
    explicit State(FlowKey k) : key(std::move(k)) {}

    const FlowKey key;
    std::mutex mutex;
    std::deque<std::function<void()>> tasks;
    bool running = false;
  };
  static void run_next(Compute& compute, std::shared_ptr<State> state);
  static void end_turn(Compute& compute, std::shared_ptr<State> state);

  const std::shared_ptr<State> state_;
};

}  // namespace sightline::server::exec
