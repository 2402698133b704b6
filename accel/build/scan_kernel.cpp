// The scan kernels, compiled once per SIMD target and chosen at run time.
#include "accel/build/scan_kernel.h"

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

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel {

HWY_EXPORT(three_axes);
HWY_EXPORT(one_axis);

void scan_three_axes(std::span<const BoxRef> refs, std::array<ScanAxis, 3>& axes) {
  HWY_DYNAMIC_DISPATCH(three_axes)(refs, axes.data());
}
void scan_one_axis(std::span<const BoxRef> refs, int axis, ScanAxis& planes) {
  HWY_DYNAMIC_DISPATCH(one_axis)(refs, axis, &planes);
}
std::string_view simd_target() {
  const std::int64_t best = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(best & -best);
}

}  // namespace sightline::accel
#endif  // HWY_ONCE
