// Notices a child process that waits for a lock that no thread will release.
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace sightline::client::importer::sandbox {

/// A child forked from a process with other threads may find a lock of its allocator taken for ever
/// by a thread that it does not have. glibc's allocator takes care of that; others do not, such as
/// the one of AddressSanitizer. A child that sleeps until such a lock is free is noticed here. One
/// that spins yields, and its filter of system calls ends it (confine.h).
class StuckWatch {
 public:
  /// Call from time to time while the child owes the next request. Returns true once it has slept,
  /// and used no processor time, in several calls in a row. Always false without /proc.
  bool is_stuck(pid_t child);

 private:
  std::uint64_t last_ticks_ = 0;
  int asleep_ = 0;
};

}  // namespace sightline::client::importer::sandbox
