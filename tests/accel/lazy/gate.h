// A thread that is stopped where a test wants it.
#pragma once

#include <atomic>

namespace sightline::accel::lazy {

/// Stops the first thread that passes, until the gate is opened.
class Gate {
 public:
  void pass() {
    bool open = false;
    if (!taken_.compare_exchange_strong(open, true)) return;
    open_.wait(false);
  }
  bool taken() const { return taken_; }
  void open() {
    open_ = true;
    open_.notify_all();
  }

 private:
  std::atomic<bool> taken_{false}, open_{false};
};

}  // namespace sightline::accel::lazy
