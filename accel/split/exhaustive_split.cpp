// Candidates, counts and costs in registers, compiled once per SIMD target and chosen at run time.
#include "accel/split/exhaustive_split.h"

#include <algorithm>
#include <array>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/split/exhaustive_split.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/split/bound_cost-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::split {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kScanWidth>;
using Counts = hn::RebindToUnsigned<Floats>;
constexpr std::size_t kLanes = hn::MaxLanes(Floats());

/// Fills unused entries: NaN fails every comparison, so it is never a candidate.
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// The bounds of one axis that lie strictly inside the cell, in list order, then kNone.
struct Candidates {
  std::size_t size = 0;
  alignas(64) float at[2 * kMaxBoundScan + kScanWidth];
};

/// As floats, a reference is two groups of four: x, y, z of a bound, and one other value.
static_assert(sizeof(kdtree::Reference) == 8 * sizeof(float));

HWY_INLINE std::size_t axis_of(int first_axis, int i) {
  const int axis = first_axis + i;
  return static_cast<std::size_t>(axis);
}

template <int kAxes>
HWY_INLINE void append(const float* groups, const geometry::Aabb& cell, int first_axis,
                       Candidates* out) {
  const Floats df;
  hn::Vec<Floats> bounds[4];
  hn::LoadInterleaved4(df, groups, bounds[0], bounds[1], bounds[2], bounds[3]);
  for (int i = 0; i < kAxes; ++i) {
    const std::size_t axis = axis_of(first_axis, i);
    const auto x = bounds[axis];
    const auto inside =
        hn::And(hn::Gt(x, hn::Set(df, cell.lo[axis])), hn::Lt(x, hn::Set(df, cell.hi[axis])));
    hn::StoreU(hn::Compress(x, inside), df, out[i].at + out[i].size);
    out[i].size += hn::CountTrue(df, inside);
  }
}

template <int kAxes>
HWY_INLINE void collect(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                        int first_axis, Candidates* out) {
  constexpr std::size_t kBoxes = (kLanes + 1) / 2;  // that fill a register
  const std::size_t whole = refs.size() / kBoxes * kBoxes;
  const auto append_all = [&](const kdtree::Reference* begin, const kdtree::Reference* end) {
    const auto* last = reinterpret_cast<const float*>(end);
    for (auto* group = reinterpret_cast<const float*>(begin); group < last; group += 4 * kLanes)
      append<kAxes>(group, cell, first_axis, out);
  };
  append_all(refs.data(), refs.data() + whole);
  if (whole == refs.size()) return;
  constexpr geometry::Vec3f kNowhere{kNone, kNone, kNone};
  std::array<kdtree::Reference, kBoxes> rest;
  std::fill(std::copy(refs.begin() + static_cast<std::ptrdiff_t>(whole), refs.end(), rest.begin()),
            rest.end(), kdtree::Reference{.lo = kNowhere, .hi = kNowhere});
  append_all(rest.data(), rest.data() + rest.size());
}

template <int kAxes>
BoundSplit best_on(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                   int first_axis, double bonus, std::uint64_t& touches) {
  const Floats df;
  const Counts du;
  const hn::RebindToSigned<Floats> di;
  Candidates candidates[kAxes];
  collect<kAxes>(refs, cell, first_axis, candidates);

  const double per_whole = per_area(cell);
  BoundSplit best;
  std::size_t longest = 0;
  for (const Candidates& c : candidates) {
    touches += (c.size + kScanWidth - 1) / kScanWidth * refs.size();
    longest = std::max(longest, c.size);
  }
  const std::size_t end = (longest + kLanes - 1) / kLanes * kLanes;
  hn::Vec<Floats> least[kAxes], where[kAxes];
  for (int a = 0; a < kAxes; ++a) {
    least[a] = hn::Set(df, std::numeric_limits<float>::infinity());
    where[a] = hn::Zero(df);
    for (std::size_t i = candidates[a].size; i < end; i += kLanes)
      hn::StoreU(hn::Set(df, kNone), df, candidates[a].at + i);
  }
  for (std::size_t begin = 0; begin < end; begin += kLanes) {
    hn::Vec<Floats> x[kAxes];
    hn::Vec<Counts> left[kAxes], right[kAxes];
    for (int a = 0; a < kAxes; ++a) {
      x[a] = hn::LoadU(df, candidates[a].at + begin);
      left[a] = right[a] = hn::Zero(du);
    }
    for (const kdtree::Reference& ref : refs) {
      const auto weight = hn::Set(du, ref.weight);
      for (int a = 0; a < kAxes; ++a) {
        const std::size_t axis = axis_of(first_axis, a);
        const auto in_left = hn::RebindMask(du, hn::Lt(hn::Set(df, ref.lo[axis]), x[a]));
        const auto in_right = hn::RebindMask(du, hn::Gt(hn::Set(df, ref.hi[axis]), x[a]));
        left[a] = hn::IfThenElse(in_left, hn::Add(left[a], weight), left[a]);
        right[a] = hn::IfThenElse(in_right, hn::Add(right[a], weight), right[a]);
      }
    }
    for (int a = 0; a < kAxes; ++a) {
      const BoundCosts costs(cell, axis_of(first_axis, a), per_whole, bonus);
      const auto cost = costs.children(df, x[a], hn::ConvertTo(df, hn::BitCast(di, left[a])),
                                       hn::ConvertTo(df, hn::BitCast(di, right[a])));
      const auto better =
          hn::Or(hn::Lt(cost, least[a]), hn::And(hn::Eq(cost, least[a]), hn::Lt(x[a], where[a])));
      least[a] = hn::IfThenElse(better, cost, least[a]);
      where[a] = hn::IfThenElse(better, x[a], where[a]);
    }
  }
  for (int a = 0; a < kAxes; ++a) {
    const float cost = hn::GetLane(hn::MinOfLanes(df, least[a]));
    if (!(cost < best.children)) continue;
    const auto first =
        hn::MinOfLanes(df, hn::IfThenElse(hn::Eq(least[a], hn::Set(df, cost)), where[a],
                                          hn::Set(df, std::numeric_limits<float>::infinity())));
    best.children = cost;
    best.plane = {first_axis + a, hn::GetLane(first)};
  }
  return best;
}

BoundSplit all_axes(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell, int,
                    double bonus, std::uint64_t& touches) {
  return best_on<3>(refs, cell, 0, bonus, touches);
}
BoundSplit one_axis(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell, int axis,
                    double bonus, std::uint64_t& touches) {
  return best_on<1>(refs, cell, axis, bonus, touches);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::split
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::split {

HWY_EXPORT(all_axes);
HWY_EXPORT(one_axis);

std::optional<kdtree::Split> choose_bound(std::span<const kdtree::Reference> refs,
                                          const geometry::Aabb& cell, const BoundRule& rule,
                                          kdtree::BuildCounters& counters) {
  const double weight = total_weight(refs);
  const BoundSplit best = best_bound(rule, cell, refs.size(), weight, [&](AxisRange range) {
    const double bonus = rule.cost.empty_bonus;
    return range.all()
               ? HWY_DYNAMIC_DISPATCH(all_axes)(refs, cell, 0, bonus, counters.touches)
               : HWY_DYNAMIC_DISPATCH(one_axis)(refs, cell, range.begin, bonus, counters.touches);
  });
  if (!best.found() || !(best.cost(rule.cost) < rule.cost.intersect * weight)) return std::nullopt;
  return kdtree::Split{best.plane};
}

}  // namespace sightline::accel::split
#endif  // HWY_ONCE
