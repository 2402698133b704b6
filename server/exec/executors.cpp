// Worker threads: the server's oneTBB arenas, and strands of tasks that run one after the other.
#include "server/exec/executors.h"

#include <utility>

namespace sightline::server::exec {

Compute::Compute(int threads)
    : threads_(threads),
      parallelism_(oneapi::tbb::global_control::max_allowed_parallelism,
                   5 * static_cast<std::size_t>(threads) + 1),
      arena_(threads, 0),
      small_(threads, 0),
      updates_(threads, 0),
      management_(threads, 0),
      background_(threads, 0) {}

Compute::~Compute() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return pending_ == 0; });
}

void Compute::begin() {
  const std::lock_guard lock(mutex_);
  ++pending_;
}

void Compute::end() {
  const std::lock_guard lock(mutex_);
  if (--pending_ == 0) idle_.notify_all();
}

void Strand::post(Compute& compute, std::function<void()> task) {
  auto state = state_;  // the task may run and destroy this strand before post() returns
  {
    const std::lock_guard lock(state->mutex);
    state->tasks.push_back(std::move(task));
    if (std::exchange(state->running, true)) return;
  }
  run_next(compute, std::move(state));
}

void Strand::run_next(Compute& compute, std::shared_ptr<State> state) {
  compute.enqueue_update([&compute, state = std::move(state)]() mutable {
    std::function<void()> task;
    {
      const std::lock_guard lock(state->mutex);
      task = std::move(state->tasks.front());
      state->tasks.pop_front();
    }
    task();
    task = nullptr;
    {
      const std::lock_guard lock(state->mutex);
      state->running = !state->tasks.empty();
      if (!state->running) return;
    }
    run_next(compute, std::move(state));
  });
}

}  // namespace sightline::server::exec
