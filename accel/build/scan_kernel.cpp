// The scan kernels, compiled once per SIMD target and chosen at run time.
#include "accel/build/scan_kernel.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/build/scan_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// kPlanes planes on each of kAxes axes from `first_axis` on. Counters stay in registers; nothing
/// is written until the pass ends.
template <int kAxes, std::size_t kPlanes>
void scan(std::span<const BoxRef> refs, int first_axis, ScanAxis* HWY_RESTRICT axes) {
  const hn::CappedTag<float, kPlanes> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  constexpr std::size_t kLanes = hn::MaxLanes(df);
  constexpr std::size_t kParts = kPlanes / kLanes;
  hn::Vec<decltype(df)> position[kAxes][kParts];
  hn::Vec<decltype(du)> left[kAxes][kParts], right[kAxes][kParts];
  for (int a = 0; a < kAxes; ++a) {
    for (std::size_t p = 0; p < kParts; ++p) {
      position[a][p] = hn::LoadU(df, axes[a].position.data() + p * kLanes);
      left[a][p] = right[a][p] = hn::Zero(du);
    }
  }
  for (const BoxRef& ref : refs) {
    const auto weight = hn::Set(du, ref.weight);
    for (int a = 0; a < kAxes; ++a) {
      const auto below = hn::Set(df, ref.lo[static_cast<std::size_t>(first_axis + a)]);
      const auto above = hn::Set(df, ref.hi[static_cast<std::size_t>(first_axis + a)]);
      for (std::size_t p = 0; p < kParts; ++p) {
        const auto in_left = hn::RebindMask(du, hn::Lt(below, position[a][p]));
        const auto in_right = hn::RebindMask(du, hn::Gt(above, position[a][p]));
        left[a][p] = hn::Add(left[a][p], hn::IfThenElseZero(in_left, weight));
        right[a][p] = hn::Add(right[a][p], hn::IfThenElseZero(in_right, weight));
      }
    }
  }
  for (int a = 0; a < kAxes; ++a) {
    for (std::size_t p = 0; p < kParts; ++p) {
      hn::StoreU(left[a][p], du, axes[a].left.data() + p * kLanes);
      hn::StoreU(right[a][p], du, axes[a].right.data() + p * kLanes);
    }
  }
}

void three_axes(std::span<const BoxRef> refs, ScanAxis* axes) {
  scan<3, kScanWidth / 2>(refs, 0, axes);
}
void one_axis(std::span<const BoxRef> refs, int axis, ScanAxis* planes) {
  scan<1, kScanWidth / 2>(refs, axis, planes);
}

/// Plain products and sums, no fused ones: every target gets the same bits.
ExactCut exact(std::span<const BoxRef> refs, int axis, std::span<const float> candidates,
               const CutTerms& terms) {
  const hn::CappedTag<float, kScanWidth> df;
  const hn::RebindToSigned<decltype(df)> di;
  constexpr std::size_t kLanes = hn::MaxLanes(df);
  const auto lo = hn::Set(df, terms.lo), hi = hn::Set(df, terms.hi);
  const auto ends = hn::Set(df, terms.ends), slope = hn::Set(df, terms.slope),
             bonus = hn::Set(df, terms.empty_bonus);
  auto best_cost = hn::Set(df, std::numeric_limits<float>::infinity());
  auto best_position = hn::Zero(df);
  ScanAxis counted;
  for (std::size_t begin = 0; begin < candidates.size(); begin += kScanWidth) {
    std::copy_n(candidates.begin() + static_cast<std::ptrdiff_t>(begin), kScanWidth,
                counted.position.begin());
    scan<1, kScanWidth>(refs, axis, &counted);
    for (std::size_t p = 0; p < kScanWidth; p += kLanes) {
      const auto x = hn::LoadU(df, counted.position.data() + p);
      const auto left = hn::ConvertTo(
          df, hn::LoadU(di, reinterpret_cast<const std::int32_t*>(counted.left.data() + p)));
      const auto right = hn::ConvertTo(
          df, hn::LoadU(di, reinterpret_cast<const std::int32_t*>(counted.right.data() + p)));
      const auto left_area = hn::Add(ends, hn::Mul(slope, hn::Sub(x, lo)));
      const auto right_area = hn::Add(ends, hn::Mul(slope, hn::Sub(hi, x)));
      const auto sum = hn::Add(hn::Mul(left_area, left), hn::Mul(right_area, right));
      const auto one_empty = hn::Eq(hn::Min(left, right), hn::Zero(df));
      const auto cost = hn::IfThenElse(one_empty, hn::Mul(sum, bonus), sum);
      const auto less = hn::Lt(cost, best_cost);
      const auto first = hn::And(hn::Eq(cost, best_cost), hn::Lt(x, best_position));
      const auto better = hn::Or(less, first);
      best_cost = hn::IfThenElse(better, cost, best_cost);
      best_position = hn::IfThenElse(better, x, best_position);
    }
  }
  std::array<float, kLanes> costs, positions;
  hn::StoreU(best_cost, df, costs.data());
  hn::StoreU(best_position, df, positions.data());
  ExactCut best{costs[0], positions[0]};
  for (std::size_t i = 1; i < kLanes; ++i) {
    if (costs[i] < best.children || (costs[i] == best.children && positions[i] < best.position)) {
      best = {costs[i], positions[i]};
    }
  }
  return best;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel {

HWY_EXPORT(three_axes);
HWY_EXPORT(one_axis);
HWY_EXPORT(exact);

void scan_three_axes(std::span<const BoxRef> refs, std::array<ScanAxis, 3>& axes) {
  HWY_DYNAMIC_DISPATCH(three_axes)(refs, axes.data());
}
void scan_one_axis(std::span<const BoxRef> refs, int axis, ScanAxis& planes) {
  HWY_DYNAMIC_DISPATCH(one_axis)(refs, axis, &planes);
}
ExactCut scan_exact(std::span<const BoxRef> refs, int axis, std::span<const float> candidates,
                    const CutTerms& terms) {
  return HWY_DYNAMIC_DISPATCH(exact)(refs, axis, candidates, terms);
}

std::string_view simd_target() {
  const std::int64_t best = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(best & -best);
}

}  // namespace sightline::accel
#endif  // HWY_ONCE
