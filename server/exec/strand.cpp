// Tasks that run one after the other.
#include "server/exec/strand.h"

#include <utility>

namespace sightline::server::exec {

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
