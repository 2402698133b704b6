// An end of a box along one axis, in 64 bits that sort in the order of the sweep. Source: Wald,
// Havran 2006, section 4.2.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::published::kd {

/// At equal positions ends come first, then boxes that lie in the plane, then starts.
enum class EventType : std::uint64_t { kEnd = 0, kPlanar = 1, kStart = 2 };

/// An end of a box along one axis. Events are ordered by (position, type, reference):
///
///     bits 32..63 position, mapped so that integers order as the floats do
///     bits 30..31 type
///     bits 0..29  index of the reference in a list
class Event {
 public:
  static constexpr std::size_t kMaxReferences = std::size_t{1} << 30;

  Event() = default;
  Event(float position, EventType type, std::uint32_t reference)
      : bits_(std::uint64_t{key(position)} << 32 | static_cast<std::uint64_t>(type) << 30 |
              reference) {}

  float position() const {
    const auto k = static_cast<std::uint32_t>(bits_ >> 32);
    return std::bit_cast<float>(k ^ ((k >> 31) != 0 ? 0x80000000u : 0xffffffffu));
  }
  EventType type() const { return static_cast<EventType>(bits_ >> 30 & 3); }
  std::uint32_t reference() const {
    return static_cast<std::uint32_t>(bits_) & (kMaxReferences - 1);
  }
  std::uint64_t bits() const { return bits_; }

  bool operator<(const Event& o) const { return bits_ < o.bits_; }
  bool operator==(const Event&) const = default;

 private:
  /// Adding zero turns -0 into +0.
  static std::uint32_t key(float position) {
    const auto u = std::bit_cast<std::uint32_t>(position + 0.0f);
    return u ^ ((u >> 31) != 0 ? 0xffffffffu : 0x80000000u);
  }

  std::uint64_t bits_;
};
static_assert(sizeof(Event) == 8);

/// Writes the one or two events of [lo, hi] to `out` and returns the end of what is written.
inline Event* put_events(float lo, float hi, std::uint32_t reference, Event* out) {
  if (hi == geometry::least_above(lo)) {
    *out++ = Event(lo, EventType::kPlanar, reference);
    return out;
  }
  *out++ = Event(lo, EventType::kStart, reference);
  *out++ = Event(hi, EventType::kEnd, reference);
  return out;
}

/// Touches of a sort of that many events.
inline std::uint64_t sort_touches(std::size_t events) {
  return events < 2 ? 0 : events * static_cast<std::uint64_t>(std::bit_width(events - 1));
}

/// Sorts events. Events of equal position and type must already be in the order of their
/// references. This is a radix sort, least digit first, over the 34 bits of position and type.
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
