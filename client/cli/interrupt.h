// Ctrl-C as a wish to stop, so that what was begun can be ended well.
#pragma once

#include <signal.h>

#include <stop_token>
#include <thread>

namespace sightline::client::cli {

/// While it lives, the first SIGINT requests a stop instead of ending the process. A second one
/// ends it as ever. One at a time.
class Interrupt {
 public:
  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  std::stop_token token() const { return stop_.get_token(); }
  bool happened() const { return stop_.stop_requested(); }

 private:
  void wait();

  std::stop_source stop_;
  struct sigaction before_ {};
  std::thread waiter_;
};

}  // namespace sightline::client::cli
