// Epoch-based reclamation: what readers may still look at is freed only after all of them have
// moved on. Source: Fraser 2004, "Practical lock-freedom", section 5.2.3.
#pragma once

#include <cstdint>

namespace sightline::accel::kdtree {

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

/// Base of what can be retired; its members are the epoch's.
struct Retirable {
  void (*free)(Retirable*) = nullptr;
  std::uint64_t bytes = 0;
  std::uint64_t epoch = 0;
  Retirable* next = nullptr;
};

/// Frees `object` by `free(&object)` once no pin that may have seen it is left. Call after it can
/// no longer be found, once. Allocates nothing and waits for nobody.
void retire(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes);

/// Retired and not yet freed.
std::uint64_t retired_bytes();

/// Frees all that can be freed now. For shutting down and for accounting; tracing does it as it
/// goes.
void reclaim();

}  // namespace sightline::accel::kdtree
