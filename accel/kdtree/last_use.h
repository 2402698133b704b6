// When something was last used, in batches of rays.
#pragma once

#include <atomic>
#include <cstdint>

namespace sightline::accel::kdtree {

/// Counts batches of rays, in the whole process: the clock of eviction.
alignas(64) inline std::atomic<std::uint32_t> batches_begun{0};

inline void begin_batch() { batches_begun.fetch_add(1, std::memory_order_relaxed); }

/// The last use of an object. Threads: any. A use costs a store for the first ray of a batch, and
/// two loads for the others.
class LastUse {
 public:
  void use() const {
    const std::uint32_t now = batches_begun.load(std::memory_order_relaxed);
    if (batch_.load(std::memory_order_relaxed) != now) batch_.store(now, std::memory_order_relaxed);
  }
  /// The number of batches begun since the last use, or since the object was made if it was not
  /// used.
  std::uint32_t age() const {
    constexpr std::uint32_t kLongest = std::uint32_t{1} << 31;
    const std::uint32_t used = batch_.load(std::memory_order_relaxed);
    const std::uint32_t age = batches_begun.load(std::memory_order_relaxed) - used;
    return age < kLongest ? age : 0;  // it was used after the other was read
  }

 private:
  mutable std::atomic<std::uint32_t> batch_{batches_begun.load(std::memory_order_relaxed)};
};

}  // namespace sightline::accel::kdtree
