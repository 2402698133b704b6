// Tasks that run one after the other, on any free worker.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "server/exec/compute.h"

namespace sightline::server::exec {

/// Uses the workers for updates. No worker waits for another task, as it would for a lock. After
/// each task the worker takes the next one in the arena, which may be of another strand. A task may
/// own the strand it runs on.
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
