// Worker threads for each kind of work, and strands of tasks that run one after the other.
#include "server/exec/executors.h"

#include <utility>

namespace sightline::server::exec {
namespace {

constexpr Priority kQueryPriority{.nice = 0, .time_slice = std::chrono::milliseconds(8)};
constexpr Priority kBackgroundPriority{.nice = 5, .time_slice = std::chrono::milliseconds(8)};
constexpr std::chrono::milliseconds kSmallLongAfter{10};

}  // namespace

Compute::Compute(int threads)
    : threads_(threads),
      parallelism_(oneapi::tbb::global_control::max_allowed_parallelism,
                   (1 + 4 * FairWorkers::kArenas) * static_cast<std::size_t>(threads) + 1),
      management_(threads, 0),
      updates_({.threads = threads}),
      background_({.threads = threads, .priority = kBackgroundPriority}),
      queries_({.threads = threads, .priority = kQueryPriority}),
      small_({.threads = threads,
              .long_after = kSmallLongAfter,
              .priority = kPrompt,
              .prompt = true}) {}

Compute::~Compute() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return pending_ == 0; });
}

void Compute::push(FairWorkers& workers, const FlowKey& key, Slice slice) {
  begin();
  try {
    workers.push(key, [this, slice = std::move(slice)]() mutable {
      if (slice()) return true;
      slice = nullptr;
      end();
      return false;
    });
  } catch (...) {
    end();
    throw;
  }
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

void Strand::run_or_post(Compute& compute, std::function<void()> task) {
  auto state = state_;  // the task may destroy this strand
  {
    const std::lock_guard lock(state->mutex);
    if (state->running) return state->tasks.push_back(std::move(task));
    state->running = true;
  }
  task();
  task = nullptr;
  end_turn(compute, std::move(state));
}

void Strand::run_next(Compute& compute, std::shared_ptr<State> state) {
  const FlowKey& key = state->key;
  compute.enqueue_update(key, [&compute, state = std::move(state)]() mutable {
    std::function<void()> task;
    {
      const std::lock_guard lock(state->mutex);
      task = std::move(state->tasks.front());
      state->tasks.pop_front();
    }
    task();
    task = nullptr;
    end_turn(compute, std::move(state));
  });
}

/// Goes on with what was posted meanwhile.
void Strand::end_turn(Compute& compute, std::shared_ptr<State> state) {
  {
    const std::lock_guard lock(state->mutex);
    state->running = !state->tasks.empty();
    if (!state->running) return;
  }
  run_next(compute, std::move(state));
}

}  // namespace sightline::server::exec
