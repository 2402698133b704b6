// Writes columns side by side in vectors, others number by number.
#include "accel/wide/answers.h"

#include <bit>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/answers.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using geometry::FieldColumn;
using geometry::HitColumns;

HWY_INLINE bool all_answered(const Outcome& outcome) {
  return outcome.answered == (1u << kLanes) - 1;
}

/// Calls put(lane) for each answered ray.
template <class Put>
HWY_INLINE void each_answered(const Outcome& outcome, const Put& put) {
  if (all_answered(outcome)) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) put(lane);
    return;
  }
  for (std::uint32_t left = outcome.answered; left != 0; left &= left - 1)
    put(static_cast<std::size_t>(std::countr_zero(left)));
}

/// Writes a field of numbers for all answered rays.
template <class T>
HWY_INLINE void put(const Outcome& outcome, const Lanes<T, kLanes>& numbers,
                    const FieldColumn<T>& field, std::size_t first) {
  std::byte* const to = field.at(first);
  if (all_answered(outcome) && field.stride == sizeof(T) &&
      reinterpret_cast<std::uintptr_t>(to) % alignof(T) == 0)
    return numbers.store_unaligned(reinterpret_cast<T*>(to));
  Column<T> column;
  numbers.store(column.data());
  each_answered(outcome, [&](std::size_t lane) {
    std::memcpy(to + lane * field.stride, &column[lane], sizeof(T));
  });
}

template <class T>
HWY_INLINE void clear(const Outcome& outcome, const FieldColumn<T>& field, std::size_t first) {
  if (!field.is_asked()) return;
  if (all_answered(outcome) && field.stride == sizeof(T)) {
    std::memset(field.at(first), 0, kLanes * sizeof(T));
    return;
  }
  std::byte* const to = field.at(first);
  each_answered(outcome,
                [&](std::size_t lane) { std::memset(to + lane * field.stride, 0, sizeof(T)); });
}

/// Writes the numbers of the rays with a described hit, and zero for others.
template <class T>
HWY_INLINE void put_described(const Outcome& outcome, std::uint32_t described,
                              const Column<T>& numbers, const FieldColumn<T>& field,
                              std::size_t first) {
  using Numbers = Lanes<T, kLanes>;
  if (!field.is_asked()) return;
  put(outcome, Numbers::pick(described, Numbers::load(numbers.data()), Numbers::set(0)), field,
      first);
}

HWY_INLINE void put_t(const Outcome& outcome, std::uint32_t described, const HitColumns& hits,
                      std::size_t first) {
  using Doubles = Lanes<double, kLanes>;
  if (!hits.t.is_asked()) return;
  const Doubles none = Doubles::pick(outcome.valid, Doubles::set(geometry::kInfinity),
                                     Doubles::set(std::numeric_limits<double>::quiet_NaN()));
  put(outcome, Doubles::pick(described, Doubles::load(outcome.best.t.data()), none), hits.t, first);
}

HWY_INLINE void put_work(const Outcome& outcome, const HitColumns& hits, std::size_t first) {
  using Numbers = Lanes<std::uint32_t, kLanes>;
  if (!hits.work.is_asked()) return;
  const Numbers flag = Numbers::set(geometry::kWorkDeferred), zero = Numbers::set(0);
  const Numbers work =
      min(Numbers::load(outcome.work.data()), Numbers::set(geometry::kWorkDeferred - 1));
  put(outcome,
      Numbers::pick(outcome.valid, work + Numbers::pick(outcome.saw_deferred, flag, zero), zero),
      hits.work, first);
}

/// Writes the state of each answered ray. `found` are the rays with a hit.
HWY_INLINE void put_state(const Outcome& outcome, std::uint32_t found, const HitColumns& hits,
                          std::size_t first) {
  using States = Lanes<std::uint8_t, kLanes>;
  if (!hits.state.is_asked()) return;
  const auto state = [](geometry::HitState s) { return States::set(static_cast<std::uint8_t>(s)); };
  const States none = States::pick(outcome.valid, state(geometry::HitState::kMiss),
                                   state(geometry::HitState::kInvalid));
  put(outcome, States::pick(found, state(geometry::HitState::kHit), none),
      FieldColumn<std::uint8_t>{hits.state.data, hits.state.stride}, first);
}

HWY_INLINE void put_bits(const Outcome& outcome, std::uint32_t found, const HitColumns& hits,
                         std::size_t first) {
  if (hits.bits == nullptr) return;
  const std::uint32_t set = found & outcome.answered;
  for (std::size_t lane = 0; lane < kLanes && first + lane < hits.size; lane += 8) {
    std::uint8_t& byte = hits.bits[(first + lane) / 8];
    const std::uint32_t kept = byte & ~(outcome.answered >> lane);
    byte = static_cast<std::uint8_t>(kept | set >> lane);
  }
}

void write_fields(const Outcome& outcome, const HitColumns& hits, std::size_t first) {
  const BestHits& best = outcome.best;
  const std::uint32_t found = best.found & outcome.valid, described = outcome.any ? 0 : found;
  put_t(outcome, described, hits, first);
  put_described(outcome, described, best.node, hits.node, first);
  put_described(outcome, described, best.primitive, hits.primitive, first);
  clear(outcome, hits.barycentric, first);
  clear(outcome, hits.normal, first);
  put_work(outcome, hits, first);
  put_state(outcome, found, hits, first);
  put_bits(outcome, found, hits, first);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(write_fields);

void write(const Outcome& outcome, const geometry::HitColumns& hits, std::size_t first) {
  HWY_DYNAMIC_DISPATCH(write_fields)(outcome, hits, first);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
