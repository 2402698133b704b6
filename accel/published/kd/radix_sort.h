// Sorts the events of one axis, once for a whole subtree.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "accel/published/kd/event.h"

namespace sightline::accel::published::kd {

/// Sorts events. Those of equal position and type must already be in the order of their references.
/// A radix sort, least digit first, over the 34 bits of position and type.
inline void sort_events(std::vector<Event>& events) {
  constexpr std::size_t kWorthIt = 4096;
  if (events.size() < kWorthIt) return std::sort(events.begin(), events.end());
  constexpr std::array<int, 3> kShift{30, 41, 52};
  constexpr std::size_t kDigits = 1u << 12;
  constexpr std::array<std::uint64_t, 3> kMask{(1u << 11) - 1, (1u << 11) - 1, kDigits - 1};
  const auto digit = [&](const Event& e, std::size_t pass) {
    return static_cast<std::size_t>(e.bits() >> kShift[pass] & kMask[pass]);
  };
  std::vector<std::array<std::size_t, 3>> start(kDigits);
  for (const Event& e : events) {
    for (std::size_t pass = 0; pass < 3; ++pass) ++start[digit(e, pass)][pass];
  }
  std::vector<Event> other(events.size());
  for (std::size_t pass = 0; pass < 3; ++pass) {
    std::size_t next = 0;
    for (auto& p : start) next += std::exchange(p[pass], next);
    for (const Event& e : events) other[start[digit(e, pass)][pass]++] = e;
    events.swap(other);
  }
}

}  // namespace sightline::accel::published::kd
