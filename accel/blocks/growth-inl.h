// The recursion of a build: bins while a set is large, then sweeps on quantized boxes. Compiled
// once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_GROWTH_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_GROWTH_INL
#undef SIGHTLINE_BLOCKS_GROWTH_INL
#else
#define SIGHTLINE_BLOCKS_GROWTH_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/bins-inl.h"
#include "accel/blocks/hierarchy.h"
#include "accel/blocks/quantize-inl.h"
#include "accel/blocks/sweep-inl.h"
#include "accel/blocks/workspace.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// A set is quantized again if its extents have become smaller than this.
inline constexpr unsigned kCoarseExtent = 24;
/// Sets of at most this many boxes keep their quantization.
inline constexpr std::size_t kFineSet = 16;

/// Whether a set can be divided down to single boxes in this many levels.
inline bool fits(std::size_t count, unsigned levels) {
  return static_cast<unsigned>(std::bit_width(count - 1)) <= levels;
}

/// Grows a hierarchy over the boxes of a workspace. Its policy makes the nodes. begin(indices,
/// count) is called before a set is swept. pays(split, count) says whether a set is to be one leaf:
/// never one of more than kFineSet boxes. leaf(indices, count, box) makes it, where box() is the
/// union of the boxes, or returns null; one box always makes a leaf. join(at, left, right) joins
/// two nodes: `at` differs for every join, and is less than the number of boxes less one.
/// grow_both(count, left, right) calls both functions, in any order or in parallel.
template <class Policy>
class Growth {
 public:
  Growth(Workspace& work, Policy& policy) : work_(work), policy_(policy) {}

  /// Grows the subtree of a range of the indices.
  const Node* grow(std::size_t first, std::size_t count, unsigned levels) {
    std::uint32_t* const indices = work_.indices.data() + first;
    if (count <= kSweptSet) return Swept(*this, indices).grow(first, count, levels);
    std::size_t left = 0;
    {
      Bins bins(work_.boxes.data(), indices, count);
      if (bins.search()) left = bins.partition(indices, work_.moved.data() + first);
    }
    if (left == 0 || !fits(std::max(left, count - left), levels - 1)) left = count / 2;
    const Node *a = nullptr, *b = nullptr;
    policy_.grow_both(
        count, [&] { a = grow(first, left, levels - 1); },
        [&] { b = grow(first + left, count - left, levels - 1); });
    return policy_.join(first + left - 1, a, b);
  }

 private:
  class Swept;

  Workspace& work_;
  Policy& policy_;
};

/// A set that is searched by sweeps, and its buffers.
template <class Policy>
class Growth<Policy>::Swept {
 public:
  Swept(Growth& growth, const std::uint32_t* indices)
      : boxes_(growth.work_.boxes.data()), policy_(growth.policy_), indices_(indices) {}

  const Node* grow(std::size_t first, std::size_t count, unsigned levels) {
    Orders orders;
    for (std::size_t a = 0; a < 3; ++a) {
      orders.own[a] = buffers_[0][a];
      orders.other[a] = buffers_[1][a];
    }
    for (std::size_t i = 0; i < count; ++i)
      orders.own[0][i] = static_cast<std::uint64_t>(i) << kIndexShift;
    policy_.begin(indices_, count);
    quantize(orders, count);
    return grow_orders(orders, first, count, levels);
  }

 private:
  const BoxLanes& box(std::uint64_t record) const { return boxes_[indices_[index_of(record)]]; }

  BoxLanes box_of(const std::uint64_t* records, std::size_t count) const {
    Pack<8> all = Pack<8>::load(box(records[0]).lanes);
    for (std::size_t i = 1; i < count; ++i) all = max(all, Pack<8>::load(box(records[i]).lanes));
    BoxLanes b;
    all.store(b.lanes);
    return b;
  }

  const Node* leaf(const std::uint64_t* records, std::size_t count) {
    std::uint32_t indices[kFineSet];
    for (std::size_t i = 0; i < count; ++i) indices[i] = indices_[index_of(records[i])];
    return policy_.leaf(indices, count, [&] { return box_of(records, count); });
  }

  /// Quantizes the boxes of a set relative to their union, and sorts them.
  HWY_NOINLINE void quantize(const Orders& orders, std::size_t count) {
    std::uint64_t records[kSweptSet];
    const Quantizer quantizer(box_of(orders.own[0], count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t old = orders.own[0][i];
      records[i] = quantizer.record(box(old)) | (old & kIndexMask << kIndexShift);
    }
    for (std::size_t a = 0; a < 3; ++a) sort_records(records, count, a, orders.own[a]);
  }

  /// The right side of a split grows first: growing the left side may overwrite what is behind it.
  HWY_NOINLINE const Node* grow_orders(const Orders& orders, std::size_t first, std::size_t count,
                                       unsigned levels) {
    if (count == 1) return leaf(orders.own[0], 1);
    OrderSplit split = sweep(orders, count);
    if (split.extent < kCoarseExtent && count > kFineSet) {
      quantize(orders, count);
      split = sweep(orders, count);
    }
    if (policy_.pays(split, count)) {
      if (const Node* const node = leaf(orders.own[0], count)) return node;
    }
    if (!fits(std::max(split.left, count - split.left), levels - 1)) split.left = count / 2;
    const Orders divided = divide(orders, count, split);
    const Node* const right =
        grow_orders(divided.behind(split.left), first + split.left, count - split.left, levels - 1);
    return policy_.join(first + split.left - 1, grow_orders(divided, first, split.left, levels - 1),
                        right);
  }

  const BoxLanes* boxes_;
  Policy& policy_;
  const std::uint32_t* indices_;
  /// The records (record-inl.h) in the order of their centers on each axis. They move from one
  /// buffer to the other as sets are divided.
  alignas(64) std::uint64_t buffers_[2][3][kSweptSet + 2 * kSpareRecords];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
