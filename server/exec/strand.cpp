// Tasks that are done one after the other.
#include "server/exec/strand.h"

#include <utility>

namespace sightline::server::exec {

void SerialQueue::post(Compute& compute, std::function<void()> task) {
  auto line = line_;  // the task may be done, and this gone, before this returns
  {
    const std::lock_guard lock(line->mutex);
    line->tasks.push_back(std::move(task));
    if (std::exchange(line->running, true)) return;
  }
  run_next(compute, std::move(line));
}

void SerialQueue::run_next(Compute& compute, std::shared_ptr<Line> line) {
  compute.enqueue_update([&compute, line = std::move(line)]() mutable {
    std::function<void()> task;
    {
      const std::lock_guard lock(line->mutex);
      task = std::move(line->tasks.front());
      line->tasks.pop_front();
    }
    task();
    task = nullptr;
    {
      const std::lock_guard lock(line->mutex);
      line->running = !line->tasks.empty();
      if (!line->running) return;
    }
    run_next(compute, std::move(line));
  });
}

}  // namespace sightline::server::exec
