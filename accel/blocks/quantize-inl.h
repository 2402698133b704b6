// Quantizes the boxes of a small set to records, and sorts them along each axis. Compiled once per
// SIMD target.
#if defined(SIGHTLINE_BLOCKS_QUANTIZE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_QUANTIZE_INL
#undef SIGHTLINE_BLOCKS_QUANTIZE_INL
#else
#define SIGHTLINE_BLOCKS_QUANTIZE_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "accel/blocks/pack-inl.h"
#include "accel/blocks/record-inl.h"
#include "accel/blocks/workspace.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// Maps boxes that lie in the box `all` to bytes. All axes have one scale, so that areas keep their
/// proportion. Bounds are rounded to the nearest byte: they steer the search only.
class Quantizer {
 public:
  explicit Quantizer(const BoxLanes& all) {
    constexpr float kMost = std::numeric_limits<float>::max();
    float extent = 0;
    for (std::size_t a = 0; a < 3; ++a) extent = std::max(extent, all.lanes[a] + all.lanes[a + 4]);
    // Products that overflow are saturated by record().
    const float scale = extent > 0 ? std::min(255.0f / std::min(extent, kMost), kMost) : 0.0f;
    BoxLanes zero{}, steps{};
    for (std::size_t a = 0; a < 3; ++a) {
      zero.lanes[a] = all.lanes[a];
      zero.lanes[a + 4] = -all.lanes[a];
      steps.lanes[a] = 255;
    }
    zero_ = Pack<8>::load(zero.lanes);
    steps_ = Pack<8>::load(steps.lanes);
    scale_ = Pack<8>::all(scale);
  }

  /// The record of a box, with index 0.
  HWY_INLINE std::uint64_t record(const BoxLanes& box) const {
    namespace hn = hwy::HWY_NAMESPACE;
    using P = Pack<8>;
    const hn::Rebind<std::uint8_t, P::D> bytes;
    const P lanes = P::load(box.lanes) - zero_;
    std::uint8_t to[8];
    for (std::size_t i = 0; i < P::kParts; ++i) {
      // Multiplication and addition are not fused, so that every target gets the same tree.
      const auto x = hn::Add(hn::Mul(lanes.part[i], scale_.part[i]), steps_.part[i]);
      hn::StoreU(hn::DemoteTo(bytes, hn::NearestInt(x)), bytes, to + i * P::kLanes);
    }
    return load_bytes(to);
  }

 private:
  static HWY_INLINE std::uint64_t load_bytes(const std::uint8_t* from) {
    std::uint64_t record;
    std::memcpy(&record, from, sizeof record);
    return record;
  }

  Pack<8> zero_, scale_, steps_;
};

/// Writes the rank of each key, which is the number of lesser keys; keys differ. Reads and writes
/// whole vectors.
HWY_INLINE void count_ranks(const std::int16_t* keys, std::size_t count, std::int16_t* ranks) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<std::int16_t, 32> d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t first = 0; first < count; first += 2 * lanes) {
    const auto k0 = hn::Load(d, keys + first), k1 = hn::Load(d, keys + first + lanes);
    auto r0 = hn::Zero(d), r1 = r0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto k = hn::Set(d, keys[i]);
      r0 = hn::Sub(r0, hn::VecFromMask(d, hn::Gt(k0, k)));
      r1 = hn::Sub(r1, hn::VecFromMask(d, hn::Gt(k1, k)));
    }
    hn::Store(r0, d, ranks + first);
    hn::Store(r1, d, ranks + first + lanes);
  }
}

/// Writes records in their order along an axis.
HWY_INLINE void sort_records(const std::uint64_t* records, std::size_t count, std::size_t axis,
                             std::uint64_t* order) {
  alignas(64) std::int16_t keys[kSweptSet], ranks[kSweptSet];
  // Signed numbers are compared faster.
  for (std::size_t i = 0; i < count; ++i)
    keys[i] = static_cast<std::int16_t>(order_key(records[i], axis) ^ 0x8000);
  count_ranks(keys, count, ranks);
  for (std::size_t i = 0; i < count; ++i) order[ranks[i]] = records[i];
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
