// Workers that run the jobs of a fair queue.
#include "server/exec/fair_workers.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

namespace sightline::server::exec {

using Clock = std::chrono::steady_clock;

class FairWorkers::Arena {
 public:
  explicit Arena(const WorkersOptions& options)
      : tasks(options.threads, options.prompt ? 1 : 0),
        priority_(tasks, options.prompt ? Priority{} : options.priority) {}

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
    turns_.notify_all();
  }
  watcher_.join();
  for (std::thread& thread : threads_) thread.join();
}

void FairWorkers::push(const FlowKey& key, Slice slice) {
  const std::lock_guard lock(mutex_);
  if (options_.prompt && threads_.empty()) threads_.emplace_back([this] { work(); });
  queue_.push(key, std::move(slice));
  ++jobs_;
  start_turns(0);
}

/// `takers`: threads that will look for a turn without being woken.
void FairWorkers::start_turns(std::size_t takers) {
  const auto threads = static_cast<std::size_t>(options_.threads);
  while (short_ < threads && queue_.ready()) {
    const auto arena = std::find_if(arenas_.begin(), arenas_.end(), [this](const auto& candidate) {
      return candidate->turns < options_.threads;
    });
    if (arena == arenas_.end()) break;
    try {
      begin_turn(**arena);
    } catch (const std::bad_alloc&) {  // the watcher tries again
      break;
    }
  }
  wake_for_turns(takers);
  if (queue_.ready()) all_busy_.notify_one();
}

void FairWorkers::begin_turn(Arena& arena) {
  const Position position = running_.insert(running_.end(), Running{});
  position->turn = queue_.take();
  position->arena = &arena;
  try {
    if (options_.prompt) {
      begun_.push_back(position);
    } else {
      arena.tasks.enqueue([this, position] { run(position); });
    }
  } catch (...) {
    queue_.end(std::move(position->turn), false, true);
    running_.erase(position);
    throw;
  }
  ++arena.turns;
  ++short_;
}

/// Makes threads until there is one for each turn. If that fails, turns wait for the threads there
/// are.
void FairWorkers::wake_for_turns(std::size_t takers) {
  if (!options_.prompt) return;
  const std::size_t left = begun_.size() - std::min(takers, begun_.size());
  for (std::size_t i = 0; i < std::min(left, asleep_); ++i) turns_.notify_one();
  try {
    while (threads_.size() < running_.size()) threads_.emplace_back([this] { work(); });
  } catch (const std::exception&) {
    return;
  }
}

/// What each thread of a prompt lane does.
void FairWorkers::work() {
  set_priority(permitted(options_.priority));
  std::unique_lock lock(mutex_);
  for (;;) {
    if (!begun_.empty()) {
      const Position position = begun_.front();
      begun_.pop_front();
      lock.unlock();
      run_in_arena(position);
      lock.lock();
      continue;
    }
    if (stopping_) return;
    ++asleep_;
    turns_.wait(lock);
    --asleep_;
  }
}

void FairWorkers::run_in_arena(Position position) {
  bool entered = false;
  try {
    position->arena->tasks.execute([&] {
      entered = true;
      run(position);
    });
  } catch (const std::bad_alloc&) {
    if (!entered) run(position);  // in an arena of the thread's own
  }
}

void FairWorkers::run(Position position) {
  {
    const std::lock_guard lock(mutex_);
    position->begun = true;
    position->charged = Clock::now();
  }
  const bool again = position->turn.run();
  if (!again) position->turn.job.front() = nullptr;  // before ~FairWorkers() may return
  const std::lock_guard lock(mutex_);
  charge(*position);
  short_ -= position->is_long ? 0 : 1;
  --position->arena->turns;
  queue_.end(std::move(position->turn), position->is_long, again);
  running_.erase(position);
  start_turns(1);
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
      try {
        queue_.mark_long(*running.turn.flow);
      } catch (const std::bad_alloc&) {
        continue;  // the next round tries again
      }
      running.is_long = true;
      --short_;
      charge(running);
    }
    start_turns(0);
    all_busy_.wait_until(lock, next);
  }
}

}  // namespace sightline::server::exec
