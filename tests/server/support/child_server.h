// sightlined in a process of its own.
#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace sightline::tests {

/// Whether the memory of a process is what it holds: the address sanitizer keeps freed memory, the
/// thread sanitizer a shadow of it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kMemoryIsPlain = false;
#else
inline constexpr bool kMemoryIsPlain = true;
#endif

struct ChildServer : ChildProcess {
  explicit ChildServer(const std::vector<std::string>& flags) : ChildProcess(SIGHTLINED, flags) {}
  /// The port that it serves, as soon as it serves; 0 if it has ended before.
  int port() { return std::atoi(rest_of_line(" port=").c_str()); }
};

}  // namespace sightline::tests
