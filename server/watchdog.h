// Ends a process that does not end by itself.
#pragma once

#include <chrono>
#include <semaphore>

namespace sightline::server {

/// Make one for the process, and never destroy it: it watches until the last static object is
/// destroyed. Its thread starts with it, so that arm() needs no resources that may have run out.
class Watchdog {
 public:
  Watchdog();

  /// The process ends after `limit`, with exit code 0 and a line on stderr, unless it has ended by
  /// itself before. Call it once.
  void arm(std::chrono::milliseconds limit);

 private:
  [[noreturn]] void watch();

  std::chrono::milliseconds limit_{0};
  std::binary_semaphore armed_{0};
};

}  // namespace sightline::server
