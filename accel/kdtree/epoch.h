// Epoch-based reclamation: an object that readers may still use is freed only after all of them
// have left its epoch. Source: Fraser 2004, "Practical lock-freedom", section 5.2.3.
#pragma once

#include <cstdint>

namespace sightline::accel::kdtree {

/// Pins its thread to an epoch: while it lives, nothing retired after its construction is freed.
/// Hold it for one block of rays, not longer. Pins nest. Threads: any. Entering is one store,
/// repeated if the epoch advanced meanwhile; leaving is one store, and frees what it can if the
/// thread has retired much.
class EpochPin {
 public:
  EpochPin();
  ~EpochPin();
  /// Leaves the epoch and enters the current one, if something waits for that. Call it between
  /// rays, when nothing that was read under the pin is used any more. It has no effect under an
  /// outer pin.
  void renew();
  /// Lets go of what retire() took, but not of what retire_for_walks() took since the pin was made
  /// or renewed. Call it within a walk, when no cell is used any more. It has no effect under an
  /// outer pin.
  void renew_for_cells();
  EpochPin(const EpochPin&) = delete;
  EpochPin& operator=(const EpochPin&) = delete;
};

/// Base class of objects that can be retired. Only retire() and reclaim() use its members.
struct Retirable {
  void (*free)(Retirable*) = nullptr;
  std::uint64_t bytes = 0;
  std::uint64_t epoch = 0;
  Retirable* next = nullptr;
  bool for_walks = false;
};

/// Calls `free(&object)` once no pin is left that may have read the object. Call it once, after new
/// readers can no longer reach the object. Allocates nothing and never waits. Threads: any. `soon`:
/// when the thread's pin is left, it frees what it can, however few bytes wait.
void retire(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes, bool soon = false);

/// Retires an object to which walks keep pointers beyond a cell: EpochPin::renew_for_cells() does
/// not let go of it. Otherwise it does what retire() does.
void retire_for_walks(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes);

/// Frees all that can be freed now. It serves shutdown and accounting; retire() also frees from
/// time to time.
void reclaim();

}  // namespace sightline::accel::kdtree
