// The scan kernels, compiled once per SIMD target and chosen at run time.
#include "accel/split/scan_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/split/scan_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::split {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The planes of one axis and their counts, in registers until the pass ends. Lane n belongs to
/// plane n.
template <std::size_t kPlanes>
class Planes {
 public:
  using Floats = hn::CappedTag<float, kPlanes>;
  using Counts = hn::RebindToUnsigned<Floats>;

  HWY_INLINE void load(const std::array<float, kPlanes>& planes,
                       const kdtree::PlaneCounts<kPlanes>& counts) {
    for (std::size_t p = 0; p < kParts; ++p) {
      at_[p] = hn::LoadU(Floats(), planes.data() + p * kLanes);
      left_[p] = hn::LoadU(Counts(), counts.left.data() + p * kLanes);
      right_[p] = hn::LoadU(Counts(), counts.right.data() + p * kLanes);
    }
  }
  HWY_INLINE void load(const PlaneNeighbours& near) {
    for (std::size_t p = 0; p < kParts; ++p) {
      below_[p] = hn::LoadU(Floats(), near.below.data() + p * kLanes);
      above_[p] = hn::LoadU(Floats(), near.above.data() + p * kLanes);
    }
  }

  HWY_INLINE void count(float lo, float hi, std::uint32_t weight) {
    const auto below = hn::Set(Floats(), lo), above = hn::Set(Floats(), hi);
    const auto more = hn::Set(Counts(), weight);
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto in_left = hn::RebindMask(Counts(), hn::Lt(below, at_[p]));
      const auto in_right = hn::RebindMask(Counts(), hn::Gt(above, at_[p]));
      left_[p] = hn::IfThenElse(in_left, hn::Add(left_[p], more), left_[p]);
      right_[p] = hn::IfThenElse(in_right, hn::Add(right_[p], more), right_[p]);
    }
  }
  /// The nearest bound of a box that ends below the plane is its upper one; of a box that begins
  /// above the plane, its lower one.
  HWY_INLINE void update_neighbours(float lo, float hi) {
    const auto lower = hn::Set(Floats(), lo), upper = hn::Set(Floats(), hi);
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto begins_below = hn::Lt(lower, at_[p]), ends_above = hn::Gt(upper, at_[p]);
      const auto next_below = hn::IfThenElse(ends_above, lower, upper);
      const auto next_above = hn::IfThenElse(begins_below, upper, lower);
      below_[p] = hn::IfThenElse(begins_below, hn::Max(below_[p], next_below), below_[p]);
      above_[p] = hn::IfThenElse(ends_above, hn::Min(above_[p], next_above), above_[p]);
    }
  }

  HWY_INLINE void store(kdtree::PlaneCounts<kPlanes>& counts) const {
    for (std::size_t p = 0; p < kParts; ++p) {
      hn::StoreU(left_[p], Counts(), counts.left.data() + p * kLanes);
      hn::StoreU(right_[p], Counts(), counts.right.data() + p * kLanes);
    }
  }
  HWY_INLINE void store(PlaneNeighbours& near) const {
    for (std::size_t p = 0; p < kParts; ++p) {
      hn::StoreU(below_[p], Floats(), near.below.data() + p * kLanes);
      hn::StoreU(above_[p], Floats(), near.above.data() + p * kLanes);
    }
  }

 private:
  static constexpr std::size_t kLanes = hn::MaxLanes(Floats());
  static constexpr std::size_t kParts = kPlanes / kLanes;
  hn::Vec<Floats> at_[kParts], below_[kParts], above_[kParts];
  hn::Vec<Counts> left_[kParts], right_[kParts];
};

void three_axes(std::span<const kdtree::Reference> refs, const std::array<UniformAxis, 3>& planes,
                std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>& counts) {
  Planes<kdtree::kUniformPlanes> along_x, along_y,
      along_z;  // separate variables, so that they stay in registers
  along_x.load(planes[0], counts[0]);
  along_y.load(planes[1], counts[1]);
  along_z.load(planes[2], counts[2]);
  for (const kdtree::Reference& ref : refs) {
    along_x.count(ref.lo.x, ref.hi.x, ref.weight);
    along_y.count(ref.lo.y, ref.hi.y, ref.weight);
    along_z.count(ref.lo.z, ref.hi.z, ref.weight);
  }
  along_x.store(counts[0]);
  along_y.store(counts[1]);
  along_z.store(counts[2]);
}

void one_axis(std::span<const kdtree::Reference> refs, std::size_t axis, const UniformAxis& planes,
              kdtree::PlaneCounts<kdtree::kUniformPlanes>& counts) {
  Planes<kdtree::kUniformPlanes> along;
  along.load(planes, counts);
  for (const kdtree::Reference& ref : refs) along.count(ref.lo[axis], ref.hi[axis], ref.weight);
  along.store(counts);
}

void wide_axis(std::span<const kdtree::Reference> refs, std::size_t axis, const WideAxis& planes,
               kdtree::PlaneCounts<kScanWidth>& counts, PlaneNeighbours& near) {
  Planes<kScanWidth> along;
  along.load(planes, counts);
  along.load(near);
  for (const kdtree::Reference& ref : refs) {
    along.count(ref.lo[axis], ref.hi[axis], ref.weight);
    along.update_neighbours(ref.lo[axis], ref.hi[axis]);
  }
  along.store(counts);
  along.store(near);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::split
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::split {

HWY_EXPORT(three_axes);
HWY_EXPORT(one_axis);
HWY_EXPORT(wide_axis);

void scan_three_axes(std::span<const kdtree::Reference> refs,
                     const std::array<UniformAxis, 3>& planes,
                     std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>& counts) {
  HWY_DYNAMIC_DISPATCH(three_axes)(refs, planes, counts);
}
void scan_one_axis(std::span<const kdtree::Reference> refs, int axis, const UniformAxis& planes,
                   kdtree::PlaneCounts<kdtree::kUniformPlanes>& counts) {
  HWY_DYNAMIC_DISPATCH(one_axis)(refs, static_cast<std::size_t>(axis), planes, counts);
}
void scan_wide_axis(std::span<const kdtree::Reference> refs, int axis, const WideAxis& planes,
                    kdtree::PlaneCounts<kScanWidth>& counts, PlaneNeighbours& near) {
  HWY_DYNAMIC_DISPATCH(wide_axis)(refs, static_cast<std::size_t>(axis), planes, counts, near);
}
std::string_view simd_target() {
  const std::int64_t best = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(best & -best);
}

}  // namespace sightline::accel::split
#endif  // HWY_ONCE
