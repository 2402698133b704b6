// The peak memory of a piece of work.
#pragma once

#include <cstdint>
#include <optional>

namespace sightline::bench {

/// Measures the process's resident memory from its construction on, as the kernel counts it (whole
/// pages, all threads).
class MemoryPeak {
 public:
  MemoryPeak();
  /// The peak since construction, minus the memory at construction, in bytes. Nothing if the kernel
  /// does not report it.
  std::optional<std::uint64_t> bytes() const;

 private:
  std::optional<std::uint64_t> before_;
};

/// The process's resident memory now; 0 if the kernel does not report it.
std::uint64_t resident_bytes();

}  // namespace sightline::bench
