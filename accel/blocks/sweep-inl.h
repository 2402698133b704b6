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
#include <cstddef>
#include <cstdint>

#include "accel/blocks/record-inl.h"
#include "accel/blocks/workspace.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// A split of a small set in two parts of an order.
struct OrderSplit {
  std::size_t axis = 0;
  std::size_t left = 0;  ///< How many go left, at least 1; less than the set has.
  float cost = 0;        ///< Sum over both sides of area * groups of four, in quantized units.
  float area = 0;        ///< Of the whole set.
  unsigned extent = 0;   ///< The largest of the whole set, of 255.
};

/// A key is a cost, an axis, and a distance from the middle, so that the least key is the cheapest
/// split and of equals the most balanced.
inline constexpr int kAxisShift = 7, kCostShift = 9;

/// Writes area * groups of four for the first 1, 2, ... records. Returns the union of all.
HWY_INLINE std::uint64_t sweep_up(const std::uint64_t* order, std::size_t count,
                                  std::uint64_t* costs) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  Records before = hn::Zero(d), sizes = hn::Iota(d, 4);
  for (std::size_t i = 0; i < count; i += kRecordLanes) {
    const Records boxes = unite(running_union(hn::LoadU(d, order + i)), before);
    before = all_last(boxes);
    hn::Store(multiply(area(boxes), hn::ShiftRight<2>(sizes)), d, costs + i);
    sizes = hn::Add(sizes, hn::Set(d, kRecordLanes));
  }
  return hn::GetLane(before);
}

/// The least key of the splits along an order. `costs`: of the left sides.
HWY_INLINE Records sweep_down(const std::uint64_t* order, std::size_t count, std::size_t axis,
                              const std::uint64_t* costs) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const std::size_t last = (count - 1) / kRecordLanes * kRecordLanes;
  const Records none = hn::Set(d, 0xffffffff), tag = hn::Set(d, axis << kAxisShift);
  Records best = none, behind = hn::Zero(d);
  for (std::size_t i = last + kRecordLanes; i > 0;) {
    i -= kRecordLanes;
    const Records boxes = unite(running_union_down(hn::LoadU(d, order + i + 1)), behind);
    behind = all_first(boxes);
    const Records left = hn::Add(hn::Iota(d, 1), hn::Set(d, i));
    const Records groups = hn::ShiftRight<2>(hn::Sub(hn::Set(d, count + 3), left));
    const Records cost = hn::Add(multiply(area(boxes), groups), hn::Load(d, costs + i));
    // Twice the distance to the middle, plus 1 on the left of it.
    const hn::RebindToSigned<RecordTag> s;
    const auto off =
        hn::Sub(hn::BitCast(s, left), hn::Set(s, static_cast<std::int64_t>(count / 2)));
    const auto distance = hn::Xor(hn::Add(off, off), hn::BroadcastSignBit(off));
    const Records key =
        hn::Or(hn::Or(hn::ShiftLeft<kCostShift>(cost), tag), hn::BitCast(d, distance));
    const auto split = hn::Lt(hn::BitCast(s, left), hn::Set(s, static_cast<std::int64_t>(count)));
    best = lesser(best, hn::IfThenElse(hn::RebindMask(d, split), key, none));
  }
  return best;
}

/// The cheapest split of `count` records, 2 to kSweptSet, from `first` on in all orders. Clears
/// what is behind them.
HWY_INLINE OrderSplit sweep(Workspace& work, std::size_t first, std::size_t count) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  alignas(64) std::uint64_t costs[3][kSweptSet];
  std::uint64_t all = 0;
  Records best = hn::Set(d, 0xffffffff);
  for (std::size_t a = 0; a < 3; ++a) {
    std::uint64_t* const order = work.orders[a] + first;
    hn::StoreU(hn::Zero(d), d, order + count);
    hn::StoreU(hn::Zero(d), d, order + count + kSpareRecords - kRecordLanes);
    all = sweep_up(order, count, costs[a]);
    best = lesser(best, sweep_down(order, count, a, costs[a]));
  }
  const std::uint64_t key = least_lane(best), zigzag = key & ((1u << kAxisShift) - 1);
  const auto off = static_cast<std::int64_t>(zigzag >> 1) ^ -static_cast<std::int64_t>(zigzag & 1);
  const Records whole = hn::Set(d, all);
  const std::uint64_t e = hn::GetLane(extents(whole));
  OrderSplit split;
  split.axis = key >> kAxisShift & 3;
  split.left = static_cast<std::size_t>(static_cast<std::int64_t>(count / 2) + off);
  split.cost = static_cast<float>(key >> kCostShift);
  split.area = static_cast<float>(hn::GetLane(area(whole)));
  split.extent = static_cast<unsigned>(std::max({e & 0xff, e >> 8 & 0xff, e >> 16}));
  return split;
}

/// Divides the other orders by the split, each stably. What is behind the set is overwritten.
HWY_INLINE void divide(Workspace& work, std::size_t first, std::size_t count,
                       const OrderSplit& split) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const hn::RebindToSigned<RecordTag> s;
  const std::uint64_t pivot =
      order_key(work.orders[split.axis][first + split.left - 1], split.axis);
  const auto last_left = hn::Set(s, static_cast<std::int64_t>(pivot));
  for (const std::size_t a : {(split.axis + 1) % 3, (split.axis + 2) % 3}) {
    std::uint64_t* const order = work.orders[a] + first;
    std::size_t left = 0, right = 0;
    // Lanes behind the end go to either side, behind its last record.
    for (std::size_t i = 0; i < count; i += kRecordLanes) {
      const Records r = hn::LoadU(d, order + i);
      const auto above = hn::Gt(hn::BitCast(s, order_key(r, split.axis)), last_left);
      const auto goes_right = hn::RebindMask(d, above);
      hn::StoreU(hn::CompressNot(r, goes_right), d, order + left);
      hn::StoreU(hn::Compress(r, goes_right), d, work.right + right);
      const std::size_t some = hn::CountTrue(d, goes_right);
      left += kRecordLanes - some;
      right += some;
    }
    for (std::size_t i = 0; i < count - split.left; i += kRecordLanes)
      hn::StoreU(hn::Load(d, work.right + i), d, order + split.left + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
