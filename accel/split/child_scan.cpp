// Sifting and counting in one pass, compiled once per SIMD target and chosen at run time.
#include "accel/split/child_scan.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/split/child_scan.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::split {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The planes of both cells along an axis share registers: the left cell's are in the lower half.
using Floats = hn::CappedTag<float, kScanWidth>;
using Counts = hn::RebindToUnsigned<Floats>;
using Box = hn::CappedTag<std::uint32_t, sizeof(kdtree::Reference) / sizeof(std::uint32_t)>;
constexpr std::size_t kLanes = hn::MaxLanes(Floats());
constexpr std::size_t kParts = kScanWidth / kLanes;
constexpr std::size_t kBoxLanes = hn::MaxLanes(Box());
constexpr std::size_t kBoxParts = sizeof(kdtree::Reference) / sizeof(std::uint32_t) / kBoxLanes;

/// Mask of the lanes that count a box: row 1 for boxes in the left cell, 2 for the right cell, 3
/// for both.
struct alignas(64) Sides {
  std::uint32_t row[4][kScanWidth];
};
constexpr Sides sides() {
  Sides s{};
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    const bool of_left = i < kdtree::kUniformPlanes;
    s.row[1][i] = of_left ? ~0u : 0u;
    s.row[2][i] = of_left ? 0u : ~0u;
    s.row[3][i] = ~0u;
  }
  return s;
}
constexpr Sides kSides = sides();

/// Planes and counts of one axis, for both cells.
struct Axis {
  hn::Vec<Floats> at[kParts];
  hn::Vec<Counts> left[kParts], right[kParts];
};

HWY_INLINE void load(const ChildScans& scans, std::size_t a, Axis& axis) {
  alignas(64) float at[kScanWidth];
  std::copy_n(scans.left_planes.at[a].begin(), kdtree::kUniformPlanes, at);
  std::copy_n(scans.right_planes.at[a].begin(), kdtree::kUniformPlanes,
              at + kdtree::kUniformPlanes);
  for (std::size_t p = 0; p < kParts; ++p) {
    axis.at[p] = hn::Load(Floats(), at + p * kLanes);
    axis.left[p] = axis.right[p] = hn::Zero(Counts());
  }
}

HWY_INLINE void count(float lo, float hi, const hn::Vec<Counts>* weight, Axis& axis) {
  const auto lower = hn::Set(Floats(), lo), upper = hn::Set(Floats(), hi);
  for (std::size_t p = 0; p < kParts; ++p) {
    const auto below = hn::RebindMask(Counts(), hn::Lt(lower, axis.at[p]));
    const auto above = hn::RebindMask(Counts(), hn::Gt(upper, axis.at[p]));
    axis.left[p] = hn::IfThenElse(below, hn::Add(axis.left[p], weight[p]), axis.left[p]);
    axis.right[p] = hn::IfThenElse(above, hn::Add(axis.right[p], weight[p]), axis.right[p]);
  }
}

HWY_INLINE void add(const hn::Vec<Counts>* counts,
                    std::array<std::uint32_t, kdtree::kUniformPlanes>& low,
                    std::array<std::uint32_t, kdtree::kUniformPlanes>& high) {
  alignas(64) std::uint32_t all[kScanWidth];
  for (std::size_t p = 0; p < kParts; ++p) hn::Store(counts[p], Counts(), all + p * kLanes);
  for (std::size_t i = 0; i < kdtree::kUniformPlanes; ++i) {
    low[i] += all[i];
    high[i] += all[kdtree::kUniformPlanes + i];
  }
}

HWY_INLINE void store(const Axis& axis, std::size_t a, ChildScans& scans) {
  add(axis.left, scans.left.axes[a].left, scans.right.axes[a].left);
  add(axis.right, scans.left.axes[a].right, scans.right.axes[a].right);
}

HWY_INLINE void copy(const hn::Vec<Box>* box, kdtree::Reference* to) {
  for (std::size_t p = 0; p < kBoxParts; ++p)
    hn::StoreU(box[p], Box(), reinterpret_cast<std::uint32_t*>(to) + p * kBoxLanes);
}

kdtree::PartitionCounts sift(std::span<const kdtree::Reference> refs, const kdtree::Plane& plane,
                             kdtree::Reference* left, kdtree::Reference* right, ChildScans& scans) {
  const auto cut = static_cast<std::size_t>(plane.axis);
  const float x = plane.position;
  Axis along_x, along_y, along_z;  // separate variables, so that they stay in registers
  load(scans, 0, along_x);
  load(scans, 1, along_y);
  load(scans, 2, along_z);
  kdtree::PartitionCounts n;
  for (std::size_t i = 0; i < refs.size(); ++i) {
    const kdtree::Reference& ref = refs[i];
    const std::size_t in_left = ref.lo[cut]<x, in_right = ref.hi[cut]> x;
    hn::Vec<Counts> weight[kParts];
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto side = hn::Load(Counts(), kSides.row[in_left | in_right << 1] + p * kLanes);
      weight[p] = hn::And(side, hn::Set(Counts(), ref.weight));
    }
    count(ref.lo.x, ref.hi.x, weight, along_x);
    count(ref.lo.y, ref.hi.y, weight, along_y);
    count(ref.lo.z, ref.hi.z, weight, along_z);
    hn::Vec<Box> box[kBoxParts];
    for (std::size_t p = 0; p < kBoxParts; ++p)
      box[p] = hn::LoadU(Box(), reinterpret_cast<const std::uint32_t*>(&ref) + p * kBoxLanes);
    copy(box, right + n.right);
    copy(box, left + n.left);
    n.left += in_left;
    n.right += in_right;
  }
  store(along_x, 0, scans);
  store(along_y, 1, scans);
  store(along_z, 2, scans);
  scans.left.references += n.left;
  scans.right.references += n.right;
  return n;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::split
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::split {

HWY_EXPORT(sift);

namespace {

/// Position of plane i of n between the faces, from 0 to 1: row n, column i.
using Shares = std::array<std::array<double, kdtree::kUniformPlanes>, kdtree::kUniformPlanes + 1>;
constexpr Shares shares() {
  Shares all{};
  for (std::size_t n = 2; n <= kdtree::kUniformPlanes; ++n) {
    for (std::size_t i = 0; i < kdtree::kUniformPlanes; ++i)
      all[n][i] = static_cast<double>(std::min(i, n - 1)) / static_cast<double>(n - 1);
  }
  return all;
}
constexpr Shares kShares = shares();

}  // namespace

ChildPlanes child_planes(const geometry::Aabb& cell, std::uint32_t n) {
  ChildPlanes planes;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto lo = static_cast<double>(cell.lo[a]), hi = static_cast<double>(cell.hi[a]);
    for (std::size_t i = 0; i < kdtree::kUniformPlanes; ++i) {
      const double share = kShares[n][i];
      planes.at[a][i] = static_cast<float>(lo * (1 - share) + hi * share);
    }
  }
  return planes;
}

kdtree::PartitionCounts sift_and_count(std::span<const kdtree::Reference> refs,
                                       const kdtree::Plane& plane, kdtree::Reference* left,
                                       kdtree::Reference* right, ChildScans& scans) {
  return HWY_DYNAMIC_DISPATCH(sift)(refs, plane, left, right, scans);
}

}  // namespace sightline::accel::split
#endif  // HWY_ONCE
