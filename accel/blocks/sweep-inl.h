// The exact search of a small set: all splits along three orders, by their cost on quantized boxes.
// Compiled once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_SWEEP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_SWEEP_INL
#undef SIGHTLINE_BLOCKS_SWEEP_INL
#else
#define SIGHTLINE_BLOCKS_SWEEP_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "accel/blocks/record-inl.h"
#include "accel/blocks/workspace.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// A split of a small set into two parts of an order.
struct OrderSplit {
  std::size_t axis = 0;
  std::size_t left = 0;  ///< Number of records that go left: at least 1, not all.
  float cost = 0;        ///< Sum over both sides of area * groups of four, in quantized units.
  float area = 0;        ///< Half the surface area of the whole set.
  unsigned extent = 0;   ///< The largest extent of the whole set, 0 to 255.
};

/// A key is a cost, an axis, and a distance from the middle. The least key is the cheapest split;
/// ties go to the first axis, then to the most balanced split.
inline constexpr int kAxisShift = 7, kCostShift = 9;

/// A set of records, sorted along each axis (`own`), and buffers to which an order can be
/// partitioned (`other`). What is behind the set in any list may be overwritten.
struct Orders {
  std::uint64_t* own[3];
  std::uint64_t* other[3];

  Orders behind(std::size_t count) const {
    Orders o = *this;
    for (std::size_t a = 0; a < 3; ++a) {
      o.own[a] += count;
      o.other[a] += count;
    }
    return o;
  }
};

/// The records from i on, and empty boxes behind the end.
HWY_INLINE Records load_records(const std::uint64_t* order, std::size_t i, std::size_t count) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const hn::RebindToSigned<RecordTag> s;
  const auto left = hn::Set(s, static_cast<std::int64_t>(count - i));
  const auto in_set = hn::RebindMask(d, hn::Lt(hn::Iota(s, 0), left));
  return hn::IfThenElseZero(in_set, hn::LoadU(d, order + i));
}

/// Writes area * groups of four for the first 1, 2, ... records. Returns the union of all.
HWY_INLINE Records sweep_up(const std::uint64_t* order, std::size_t count, std::uint64_t* costs) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  Records before = hn::Zero(d), sizes = hn::Iota(d, 4);
  for (std::size_t i = 0; i < count; i += kRecordLanes) {
    const Records boxes = unite(running_union(load_records(order, i, count)), before);
    before = all_last(boxes);
    hn::Store(multiply(area(boxes), hn::ShiftRight<2>(sizes)), d, costs + i);
    sizes = hn::Add(sizes, hn::Set(d, kRecordLanes));
  }
  return before;
}

/// Returns the least key of the splits along an order. `costs` are the costs of the left sides.
HWY_INLINE Records sweep_down(const std::uint64_t* order, std::size_t count, std::size_t axis,
                              const std::uint64_t* costs) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const hn::RebindToSigned<RecordTag> s;
  const std::size_t last = (count - 1) / kRecordLanes * kRecordLanes;
  const Records none = hn::Set(d, 0xffffffff), tag = hn::Set(d, axis << kAxisShift);
  const auto size = hn::Set(s, static_cast<std::int64_t>(count)),
             middle = hn::Set(s, static_cast<std::int64_t>(count / 2));
  Records best = none, behind = hn::Zero(d);
  for (std::size_t i = last + kRecordLanes; i > 0;) {
    i -= kRecordLanes;
    const Records boxes = unite(running_union_down(load_records(order, i, count)), behind);
    const Records right = next_lanes(boxes, behind);
    behind = all_first(boxes);
    const Records left = hn::Add(hn::Iota(d, 1), hn::Set(d, i));
    const Records groups = hn::ShiftRight<2>(hn::Sub(hn::Set(d, count + 3), left));
    const Records cost = hn::Add(multiply(area(right), groups), hn::Load(d, costs + i));
    // The distance x from the middle in zigzag code: 2 x, or -2 x - 1 on the left of it.
    const auto off = hn::Sub(hn::BitCast(s, left), middle);
    const auto distance = hn::Xor(hn::Add(off, off), hn::BroadcastSignBit(off));
    const Records key =
        hn::Or(hn::Or(hn::ShiftLeft<kCostShift>(cost), tag), hn::BitCast(d, distance));
    const auto is_split = hn::RebindMask(d, hn::Lt(hn::BitCast(s, left), size));
    best = lesser(best, hn::IfThenElse(is_split, key, none));
  }
  return best;
}

/// Returns the cheapest split of `count` records, 2 to kSweptSet.
HWY_INLINE OrderSplit sweep(const Orders& orders, std::size_t count) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  alignas(64) std::uint64_t costs[3][kSweptSet];
  Records whole = hn::Zero(d), best = hn::Set(d, 0xffffffff);
  for (std::size_t a = 0; a < 3; ++a) {
    whole = sweep_up(orders.own[a], count, costs[a]);
    best = lesser(best, sweep_down(orders.own[a], count, a, costs[a]));
  }
  const std::uint64_t key = least_lane(best), zigzag = key & ((1u << kAxisShift) - 1);
  const auto off = static_cast<std::int64_t>(zigzag >> 1) ^ -static_cast<std::int64_t>(zigzag & 1);
  const std::uint64_t e = hn::GetLane(extents(whole));
  OrderSplit split;
  split.axis = key >> kAxisShift & 3;
  split.left = static_cast<std::size_t>(static_cast<std::int64_t>(count / 2) + off);
  split.cost = static_cast<float>(key >> kCostShift);
  split.area = static_cast<float>(hn::GetLane(area(whole)));
  split.extent = static_cast<unsigned>(std::max({e & 0xff, e >> 8 & 0xff, e >> 16}));
  return split;
}

/// Partitions an order stably: first come the `left` records whose key on the axis is at most
/// `pivot`, then the others.
HWY_INLINE void partition(const std::uint64_t* order, std::size_t count, std::size_t axis,
                          std::uint64_t pivot, std::size_t left, std::uint64_t* to) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const hn::RebindToSigned<RecordTag> s;
  const auto last_left = hn::Set(s, static_cast<std::int64_t>(pivot));
  const auto right_lanes = [&](Records r) HWY_ATTR {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(s, hn::Gt(hn::BitCast(s, order_key(r, axis)), last_left), bits);
    return std::size_t{bits[0]};
  };
  constexpr std::size_t kAll = (std::size_t{1} << kRecordLanes) - 1;
  // Every store writes a whole vector. Lanes beyond `count` may go to either part, but come behind
  // its last record, and the right part overwrites what the left part writes behind its end.
  // Nothing is loaded from `to`, so no load waits for a store.
  for (std::size_t i = 0, at = 0; i < count; i += kRecordLanes) {
    const Records r = hn::LoadU(d, order + i);
    const std::size_t lanes = right_lanes(r) ^ kAll;
    hn::StoreU(compress(r, lanes), d, to + at);
    at += static_cast<std::size_t>(std::popcount(lanes));
  }
  for (std::size_t i = 0, at = left; i < count; i += kRecordLanes) {
    const Records r = hn::LoadU(d, order + i);
    const std::size_t lanes = right_lanes(r);
    hn::StoreU(compress(r, lanes), d, to + at);
    at += static_cast<std::size_t>(std::popcount(lanes));
  }
}

/// Divides the set. The right part is behind the left one in all lists.
HWY_INLINE Orders divide(const Orders& orders, std::size_t count, const OrderSplit& split) {
  const std::uint64_t pivot = order_key(orders.own[split.axis][split.left - 1], split.axis);
  Orders divided = orders;
  for (const std::size_t a : {(split.axis + 1) % 3, (split.axis + 2) % 3}) {
    partition(orders.own[a], count, split.axis, pivot, split.left, orders.other[a]);
    std::swap(divided.own[a], divided.other[a]);
  }
  return divided;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
