// How much memory a piece of work holds at its highest.
#pragma once

#include <cstdint>
#include <optional>

namespace sightline::bench {

/// Watches the process's resident memory from its making on, as the kernel counts it (whole pages,
/// every thread).
class MemoryPeak {
 public:
  MemoryPeak();
  /// The highest mark since, less the mark at the beginning, in bytes. Nothing where the kernel
  /// does not tell.
  std::optional<std::uint64_t> bytes() const;

 private:
  std::optional<std::uint64_t> before_;
};

}  // namespace sightline::bench
