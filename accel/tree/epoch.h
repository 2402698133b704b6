// Epoch-based reclamation: what readers may still look at is freed only after all of them have
// moved on. Source: Fraser 2004, "Practical lock-freedom", section 5.2.3.
#pragma once

#include <cstdint>

namespace sightline::accel {

/// While one lives, nothing retired after it began is freed. Held for one block of rays, never
/// longer. Nests. Threads: any; entering is a store, repeated if the epoch moved on meanwhile,
/// leaving another.
class EpochPin {
 public:
  EpochPin();
  ~EpochPin();
  EpochPin(const EpochPin&) = delete;
  EpochPin& operator=(const EpochPin&) = delete;
};

/// Frees `object` by `free(object)` once no pin that may have seen it is left. Call after it can no
/// longer be found.
void retire(void* object, void (*free)(void*), std::uint64_t bytes);

/// Retired and not yet freed.
std::uint64_t retired_bytes();

/// Frees all that can be freed now. For shutting down and for accounting; tracing does it as it
/// goes.
void reclaim();

}  // namespace sightline::accel
