// Returns freed memory to the system.
#pragma once

#include <cstdint>

namespace sightline::server::exec {

/// The C library keeps freed pages in the middle of its heap. Threads: one at a time.
class HeapTrimmer {
 public:
  /// The least that is worth a pass over the heap, and the least share of the heap.
  static constexpr std::uint64_t kLeastBytes = std::uint64_t{1} << 20;
  static constexpr std::uint64_t kLeastShare = 16;

  /// Call it from time to time with the bytes that the process holds now. True: the heap was
  /// trimmed, since much was freed after the last time, and freeing has come to rest.
  bool observe(std::uint64_t held);

 private:
  std::uint64_t most_ = 0;  // since the heap was trimmed
  std::uint64_t last_ = 0;
};

}  // namespace sightline::server::exec
