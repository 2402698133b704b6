// Workers that run the jobs of a fair queue.
#include "server/exec/fair_workers.h"

#include <algorithm>
#include <new>
#include <utility>

namespace sightline::server::exec {

using Clock = std::chrono::steady_clock;

class FairWorkers::Arena {
 public:
  explicit Arena(const WorkersOptions& options)
      : tasks(options.threads, 0), priority_(tasks, options.priority) {}

  oneapi::tbb::task_arena tasks;
  int turns = 0;

 private:
  ArenaPriority priority_;
};

FairWorkers::FairWorkers(const WorkersOptions& options)
    : options_(options), queue_(static_cast<std::size_t>(options.threads)) {
  for (std::size_t i = 0; i < kArenas; ++i) arenas_.push_back(std::make_unique<Arena>(options));
  watcher_ = std::thread([this] { watch(); });
}

FairWorkers::~FairWorkers() {
  {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return jobs_ == 0; });
    stopping_ = true;
    all_busy_.notify_all();
  }
  watcher_.join();
}

void FairWorkers::push(const FlowKey& key, Slice slice) {
  const std::lock_guard lock(mutex_);
  queue_.push(key, std::move(slice));
  ++jobs_;
  start_turns();
}

/// A task for each turn, so that between two turns a worker serves the tasks of its arena.
void FairWorkers::start_turns() {
  const auto threads = static_cast<std::size_t>(options_.threads);
  while (short_ < threads && queue_.ready()) {
    const auto arena = std::find_if(arenas_.begin(), arenas_.end(), [this](const auto& candidate) {
      return candidate->turns < options_.threads;
    });
    if (arena == arenas_.end()) return;
    try {
      begin_turn(**arena);
    } catch (const std::bad_alloc&) {  // the watcher tries again
      break;
    }
  }
  if (queue_.ready()) all_busy_.notify_one();
}

void FairWorkers::begin_turn(Arena& arena) {
  const Position position = running_.insert(running_.end(), Running{});
  position->turn = queue_.take();
  position->arena = &arena;
  try {
    arena.tasks.enqueue([this, position] { run(position); });
  } catch (...) {
    queue_.end(std::move(position->turn), false, true);
    running_.erase(position);
    throw;
  }
  ++arena.turns;
  ++short_;
}

void FairWorkers::run(Position position) {
  {
    const std::lock_guard lock(mutex_);
    position->begun = true;
    position->charged = Clock::now();
  }
  const bool again = position->turn.slice();
  if (!again) position->turn.slice = nullptr;  // before ~FairWorkers() may return
  const std::lock_guard lock(mutex_);
  charge(*position);
  short_ -= position->is_long ? 0 : 1;
  --position->arena->turns;
  queue_.end(std::move(position->turn), position->is_long, again);
  running_.erase(position);
  start_turns();
  if (!again && --jobs_ == 0) idle_.notify_all();
}

void FairWorkers::charge(Running& running) {
  const auto now = Clock::now();
  queue_.charge(*running.turn.flow, now - running.charged);
  running.charged = now;
}

/// While jobs wait for workers, looks for turns that have become long.
void FairWorkers::watch() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (!queue_.ready()) {
      all_busy_.wait(lock);
      continue;
    }
    const auto now = Clock::now();
    auto next = now + options_.long_after;
    for (Running& running : running_) {
      if (!running.begun || running.is_long) continue;
      if (running.charged + options_.long_after > now) {
        next = std::min(next, running.charged + options_.long_after);
        continue;
      }
      running.is_long = true;
      --short_;
      charge(running);
      queue_.mark_long(*running.turn.flow);
    }
    start_turns();
    all_busy_.wait_until(lock, next);
  }
}

}  // namespace sightline::server::exec
