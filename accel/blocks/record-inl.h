// Boxes quantized to bytes: eight in a 512-bit vector. Compiled once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_RECORD_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_RECORD_INL
#undef SIGHTLINE_BLOCKS_RECORD_INL
#else
#define SIGHTLINE_BLOCKS_RECORD_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// A record is a 64-bit number of bytes: 255 - lo.x, 255 - lo.y, 255 - lo.z, the index in the set,
/// hi.x, hi.y, hi.z, 0. The union of boxes is the maximum of all bytes, and 0 is an empty box.
using RecordTag = hwy::HWY_NAMESPACE::CappedTag<std::uint64_t, 8>;
using Records = hwy::HWY_NAMESPACE::Vec<RecordTag>;
inline constexpr std::size_t kRecordLanes = hwy::HWY_NAMESPACE::MaxLanes(RecordTag());

inline constexpr int kIndexShift = 24, kUpperShift = 32;
inline constexpr std::uint64_t kIndexMask = 0x7f;

HWY_INLINE std::size_t index_of(std::uint64_t record) { return record >> kIndexShift & kIndexMask; }

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE Records unite(Records a, Records b) {
  std::uint64_t out = 0;
  for (int s = 0; s < 64; s += 8) out |= std::max(a.raw >> s & 0xff, b.raw >> s & 0xff) << s;
  return Records(out);
}
HWY_INLINE Records extents(Records r) {
  std::uint64_t out = 0;
  for (int s = 0; s < kIndexShift; s += 8) {
    const std::uint64_t lo = (r.raw >> s & 0xff) ^ 0xff, hi = r.raw >> (s + kUpperShift) & 0xff;
    out |= (hi > lo ? hi - lo : 0) << s;
  }
  return Records(out);
}
HWY_INLINE Records multiply(Records a, Records b) { return Records(a.raw * b.raw); }
HWY_INLINE Records lesser(Records a, Records b) { return Records(std::min(a.raw, b.raw)); }
HWY_INLINE std::uint64_t least_lane(Records keys) { return keys.raw; }

#else

/// The union of two boxes in every lane.
HWY_INLINE Records unite(Records a, Records b) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint8_t, RecordTag> bytes;
  return hn::BitCast(RecordTag(), hn::Max(hn::BitCast(bytes, a), hn::BitCast(bytes, b)));
}

/// Extents along x, y, z in the lowest bytes; the others are 0.
HWY_INLINE Records extents(Records r) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint8_t, RecordTag> bytes;
  const auto hi = hn::BitCast(bytes, hn::ShiftRight<kUpperShift>(r));
  return hn::BitCast(RecordTag(), hn::SaturatedSub(hi, hn::BitCast(bytes, hn::Not(r))));
}

/// The product of the lower halves.
HWY_INLINE Records multiply(Records a, Records b) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint32_t, RecordTag> halves;
  return hn::MulEven(hn::BitCast(halves, a), hn::BitCast(halves, b));
}

/// The minimum of numbers that need 32 bits.
HWY_INLINE Records lesser(Records a, Records b) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint32_t, RecordTag> halves;
  return hn::BitCast(RecordTag(), hn::Min(hn::BitCast(halves, a), hn::BitCast(halves, b)));
}
HWY_INLINE std::uint64_t least_lane(Records keys) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint32_t, RecordTag> halves;
  const Records upper = hn::Set(RecordTag(), ~std::uint64_t{0} << 32);
  return hn::GetLane(hn::MinOfLanes(halves, hn::BitCast(halves, hn::Or(keys, upper))));
}

#endif

/// Half the surface area, at most 3 * 255^2.
HWY_INLINE Records area(Records r) {
  namespace hn = hwy::HWY_NAMESPACE;
  const Records byte = hn::Set(RecordTag(), 0xff);
  const Records e = extents(r), yz = hn::ShiftRight<8>(e);
  const Records x = hn::And(e, byte), y = hn::And(yz, byte), z = hn::ShiftRight<8>(yz);
  return hn::Add(multiply(x, hn::Add(y, z)), multiply(y, z));
}

/// A key of 16 bits that sorts along an axis: by center, then by index.
HWY_INLINE Records order_key(Records r, std::size_t axis) {
  namespace hn = hwy::HWY_NAMESPACE;
  const Records byte = hn::Set(RecordTag(), 0xff);
  const Records bounds = hn::ShiftRightSame(r, static_cast<int>(8 * axis));
  const Records lo = hn::Xor(hn::And(bounds, byte), byte);
  const Records hi = hn::And(hn::ShiftRight<kUpperShift>(bounds), byte);
  const Records index = hn::And(hn::ShiftRight<kIndexShift>(r), hn::Set(RecordTag(), kIndexMask));
  return hn::Or(hn::ShiftLeft<7>(hn::Add(lo, hi)), index);
}
HWY_INLINE std::uint64_t order_key(std::uint64_t record, std::size_t axis) {
  const std::uint64_t bounds = record >> (8 * axis);
  const std::uint64_t center = ((bounds & 0xff) ^ 0xff) + (bounds >> kUpperShift & 0xff);
  return center << 7 | index_of(record);
}

/// The lanes that a step of a running union reads, by lane.
struct LaneTable {
  std::int64_t earlier[kRecordLanes], later[kRecordLanes];
};
template <std::size_t kStep>
inline constexpr LaneTable kLaneTable = [] {
  LaneTable t{};
  for (std::size_t i = 0; i < kRecordLanes; ++i) {
    t.earlier[i] = static_cast<std::int64_t>(i < kStep ? 0 : i - kStep);
    t.later[i] = static_cast<std::int64_t>(std::min(i + kStep, kRecordLanes - 1));
  }
  return t;
}();

HWY_INLINE Records pick_lanes(Records r, const std::int64_t* lanes) {
  namespace hn = hwy::HWY_NAMESPACE;
  return hn::TableLookupLanes(r, hn::SetTableIndices(RecordTag(), lanes));
}

/// Lane i of the result is the union of lanes 0 to i. A lane that has no earlier one unites with
/// lane 0 again, which changes nothing.
HWY_INLINE Records running_union(Records r) {
  if constexpr (kRecordLanes > 1) r = unite(r, pick_lanes(r, kLaneTable<1>.earlier));
  if constexpr (kRecordLanes > 2) r = unite(r, pick_lanes(r, kLaneTable<2>.earlier));
  if constexpr (kRecordLanes > 4) r = unite(r, pick_lanes(r, kLaneTable<4>.earlier));
  return r;
}
/// Lane i of the result is the union of lanes i to the last.
HWY_INLINE Records running_union_down(Records r) {
  if constexpr (kRecordLanes > 1) r = unite(r, pick_lanes(r, kLaneTable<1>.later));
  if constexpr (kRecordLanes > 2) r = unite(r, pick_lanes(r, kLaneTable<2>.later));
  if constexpr (kRecordLanes > 4) r = unite(r, pick_lanes(r, kLaneTable<4>.later));
  return r;
}
/// Lane i of the result is lane i + 1 of `r`; the last one is that of `behind`.
HWY_INLINE Records next_lanes(Records r, Records behind) {
  namespace hn = hwy::HWY_NAMESPACE;
  if constexpr (kRecordLanes == 1) return behind;
  const hn::RebindToSigned<RecordTag> s;
  const auto last = hn::Set(s, static_cast<std::int64_t>(kRecordLanes - 1));
  const auto is_last = hn::RebindMask(RecordTag(), hn::Eq(hn::Iota(s, 0), last));
  return hn::IfThenElse(is_last, behind, pick_lanes(r, kLaneTable<1>.later));
}
HWY_INLINE Records all_first(Records r) { return pick_lanes(r, kLaneTable<kRecordLanes>.earlier); }
HWY_INLINE Records all_last(Records r) { return pick_lanes(r, kLaneTable<kRecordLanes>.later); }

/// For every set of lanes, a bit each, the numbers of its lanes in four bits each, from the lowest
/// on, and then zeros. hn::Compress is not used, as g++ copies its table to the stack at every
/// call.
inline constexpr auto kLaneSets = [] {
  std::array<std::uint64_t, std::size_t{1} << kRecordLanes> sets{};
  for (std::size_t set = 0; set < sets.size(); ++set) {
    int shift = 0;
    for (std::size_t lane = 0; lane < kRecordLanes; ++lane) {
      if ((set >> lane & 1) == 0) continue;
      sets[set] |= static_cast<std::uint64_t>(lane) << shift;
      shift += 4;
    }
  }
  return sets;
}();

/// Moves the lanes of a set to the front.
HWY_INLINE Records compress(Records r, std::size_t set) {
  namespace hn = hwy::HWY_NAMESPACE;
  const RecordTag d;
  const Records shifts = hn::ShiftLeft<2>(hn::Iota(d, 0));
  const Records lanes = hn::And(hn::Shr(hn::Set(d, kLaneSets[set]), shifts), hn::Set(d, 7));
  return hn::TableLookupLanes(r, hn::IndicesFromVec(d, lanes));
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
