// Returns freed memory to the system.
#pragma once

#include <cstdint>
#include <limits>

namespace sightline::server::exec {

/// The C library keeps freed pages in the middle of its heap. The trimmer returns those of what was
/// dropped, and of what building trees took for a while. Threads: one at a time.
class HeapTrimmer {
 public:
  /// Freed bytes for which a pass over the heap pays: this many, and 1 / kLeastShare of the most
  /// that was held.
  static constexpr std::uint64_t kLeastBytes = std::uint64_t{1} << 20;
  static constexpr std::uint64_t kLeastShare = 16;
  /// A pass also pays for this many resident bytes that are not held, more than there once were,
  /// and 1 / kLeastScratchShare of the resident ones. Trees that are still built use them again:
  /// what is held must have been steady for kSteadyCalls calls. Where a pass returns little, these
  /// bytes are still in use, such as those of a connection's calls, which have no account. Nothing
  /// shows when they are freed later, so further passes follow, each after twice as many calls.
  static constexpr std::uint64_t kLeastScratch = std::uint64_t{16} << 20;
  static constexpr std::uint64_t kLeastScratchShare = 8;
  static constexpr std::uint64_t kSteadyCalls = 4;

  /// Call it from time to time with the bytes that the process holds now, by its own account, and
  /// those that are resident (0: not known). True: the heap was trimmed, since much was freed after
  /// the last time, and nothing is being freed or built.
  bool observe(std::uint64_t held, std::uint64_t resident);

 private:
  bool is_scratch_worth_it(std::uint64_t held, std::uint64_t resident);

  std::uint64_t most_ = 0;  // since the heap was trimmed
  std::uint64_t last_ = 0;
  std::uint64_t steady_ = 0;  // calls
  std::uint64_t least_unheld_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t least_since_pass_ = 0;  // unheld bytes, since the last pass for scratch
  std::uint64_t calls_since_pass_ = 1;  // there was none
  std::uint64_t calls_between_ = kSteadyCalls;
};

/// The resident bytes of this process; 0 if the system does not say.
std::uint64_t resident_bytes();

}  // namespace sightline::server::exec
