// Tasks that are done one after the other, on whichever worker is free.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "server/exec/compute.h"

namespace sightline::server::exec {

/// On the workers for updates. None waits for another task, as it would for a lock; between two
/// tasks other queues get their turn. What a task holds may hold the queue itself.
class SerialQueue {
 public:
  /// Runs task() after all that were posted before. It must not throw. Threads: any.
  void post(Compute& compute, std::function<void()> task);

 private:
  struct Line {
    std::mutex mutex;
    std::deque<std::function<void()>> tasks;
    bool running = false;
  };
  static void run_next(Compute& compute, std::shared_ptr<Line> line);

  const std::shared_ptr<Line> line_ = std::make_shared<Line>();
};

}  // namespace sightline::server::exec
