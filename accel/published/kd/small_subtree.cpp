// Subtrees of a few references, compiled once per SIMD target and chosen at run time.
#include "accel/published/kd/small_subtree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/published/kd/small_subtree.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/split/bound_cost-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::published::kd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A set of references: bit i is reference i.
using Set = std::uint8_t;
/// Number of bounds along one axis; lower bounds come first.
constexpr std::size_t kBounds = 2 * kSmallList;

class SmallGrowth {
 public:
  SmallGrowth(const split::BoundRule& rule, int max_depth, std::span<const kdtree::Reference> refs,
              const PlainTask& task)
      : rule_(rule), max_depth_(max_depth), refs_(refs), task_(task) {
    prepare();
  }

  PlainNode grow(Set set, const geometry::Aabb& cell, int depth) {
    const auto size = static_cast<std::size_t>(std::popcount(set));
    Choice cut;
    if (depth < max_depth_ && size > 0) cut = choose(set, size, cell);
    if (!cut.found()) return task_.out.leaf(list_of(set));
    if (!task_.out.may_cut()) return task_.out.failed_leaf(list_of(set));
    task_.counters.touches += size;
    const Axis& axis = axes_[static_cast<std::size_t>(cut.plane.axis)];
    const Set left = set & axis.below[cut.bound], right = set & axis.above[cut.bound];
    if (left == set && right == set) return task_.out.leaf(list_of(set));  // separates nothing
    const geometry::HalvedCell halves = halve(cell, cut.plane.axis, cut.plane.position);
    const std::uint32_t pair = task_.out.begin_pair();
    const PlainNode below = grow(left, halves.left, depth + 1);
    task_.out.end_pair(pair, below, grow(right, halves.right, depth + 1));
    return PlainNode::inner(cut.plane, pair);
  }

 private:
  using Floats = hn::CappedTag<float, kBounds>;
  static constexpr std::size_t kLanes = hn::MaxLanes(Floats());
  static constexpr std::size_t kParts = kBounds / kLanes;

  struct Axis {
    alignas(64) std::array<float, kBounds> at;
    alignas(16) std::array<Set, kBounds> below,
        above;  ///< References with lo < at, and with hi > at.
  };

  /// A split, and the index of its bound.
  struct Choice : split::BoundSplit {
    std::size_t bound = 0;
  };

  /// Stores the positions of all axes first: a vector load soon after scalar stores would wait for
  /// them.
  void prepare() {
    for (Axis& axis : axes_) axis.at.fill(std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < refs_.size(); ++i) {
      for (std::size_t a = 0; a < 3; ++a) {
        axes_[a].at[i] = refs_[i].lo[a];
        axes_[a].at[kSmallList + i] = refs_[i].hi[a];
      }
    }
    for (std::size_t a = 0; a < 3; ++a) find_sides(axes_[a], a);
  }

  void find_sides(Axis& axis, std::size_t a) const {
    const Floats df;
    const hn::RebindToUnsigned<Floats> du;
    const hn::Rebind<Set, Floats> ds;
    for (std::size_t p = 0; p < kBounds; p += kLanes) {
      const auto x = hn::LoadU(df, axis.at.data() + p);
      auto below = hn::Zero(du), above = hn::Zero(du);
      for (std::size_t i = 0; i < refs_.size(); ++i) {
        const auto bit = hn::Set(du, std::uint32_t{1} << i);
        const auto is_below = hn::RebindMask(du, hn::Lt(hn::Set(df, refs_[i].lo[a]), x));
        const auto is_above = hn::RebindMask(du, hn::Gt(hn::Set(df, refs_[i].hi[a]), x));
        below = hn::IfThenElse(is_below, hn::Or(below, bit), below);
        above = hn::IfThenElse(is_above, hn::Or(above, bit), above);
      }
      hn::StoreU(hn::TruncateTo(ds, below), ds, axis.below.data() + p);
      hn::StoreU(hn::TruncateTo(ds, above), ds, axis.above.data() + p);
    }
  }

  /// Costs of splits along one axis; infinite for bounds that are no candidates.
  struct Costs {
    hn::Vec<Floats> at[kParts];
    hn::Vec<Floats> least;  ///< Minimum over the parts, per lane.
  };

  Choice choose(Set set, std::size_t size, const geometry::Aabb& cell) {
    Costs costs[3];
    const Floats df;
    const auto weight = static_cast<double>(size);
    const double per_whole = split::per_area(cell);
    Choice best{best_bound(rule_, cell, size, weight, [&](split::AxisRange range) {
      auto least = hn::Set(df, std::numeric_limits<float>::infinity());
      for (int axis = range.begin; axis < range.end; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        weigh(axes_[a], set, size,
              split::HWY_NAMESPACE::BoundCosts(cell, a, per_whole, rule_.cost.empty_bonus),
              costs[a]);
        least = hn::Min(least, costs[a].least);
      }
      least = hn::MinOfLanes(df, least);
      int axis = range.begin;
      while (axis + 1 < range.end &&
             hn::AllFalse(df, hn::Eq(costs[static_cast<std::size_t>(axis)].least, least)))
        ++axis;
      return split::BoundSplit{.plane = {axis, 0}, .children = hn::GetLane(least)};
    })};
    if (!best.found() || !(best.cost(rule_.cost) < rule_.cost.intersect * weight)) return {};
    locate(costs[static_cast<std::size_t>(best.plane.axis)], best);
    return best;
  }

  void weigh(const Axis& axis, Set set, std::size_t size,
             const split::HWY_NAMESPACE::BoundCosts& rule, Costs& costs) {
    const Floats df;
    const hn::Rebind<Set, Floats> ds;
    const hn::RebindToSigned<Floats> di;
    const auto lo = hn::Set(df, rule.lo), hi = hn::Set(df, rule.hi);
    const auto none = hn::Set(df, std::numeric_limits<float>::infinity());
    costs.least = none;
    std::size_t candidates = 0;
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto weight = [&](const std::array<Set, kBounds>& side) {
        const auto common = hn::And(hn::LoadU(ds, side.data() + p * kLanes), hn::Set(ds, set));
        return hn::ConvertTo(df, hn::PromoteTo(di, hn::PopulationCount(common)));
      };
      const auto owners = static_cast<std::uint16_t>(set * 0x101u >> (p * kLanes));
      const std::uint8_t bits[8] = {static_cast<std::uint8_t>(owners),
                                    static_cast<std::uint8_t>(owners >> 8)};
      const auto x = hn::LoadU(df, axis.at.data() + p * kLanes);
      const auto inside =
          hn::And(hn::And(hn::Gt(x, lo), hn::Lt(x, hi)), hn::LoadMaskBits(df, bits));
      candidates += hn::CountTrue(df, inside);
      costs.at[p] = hn::IfThenElse(
          inside, rule.children(df, x, weight(axis.below), weight(axis.above)), none);
      costs.least = hn::Min(costs.least, costs.at[p]);
    }
    task_.counters.touches += (candidates + split::kScanWidth - 1) / split::kScanWidth * size;
  }

  /// Finds the least position among the splits of that cost, and a bound there.
  void locate(const Costs& costs, Choice& best) const {
    const Floats df;
    const Axis& axis = axes_[static_cast<std::size_t>(best.plane.axis)];
    const auto wanted = hn::Set(df, best.children);
    auto first = hn::Set(df, std::numeric_limits<float>::infinity());
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto x = hn::LoadU(df, axis.at.data() + p * kLanes);
      first = hn::IfThenElse(hn::Eq(costs.at[p], wanted), hn::Min(first, x), first);
    }
    first = hn::MinOfLanes(df, first);
    best.plane.position = hn::GetLane(first);
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto there =
          hn::FindFirstTrue(df, hn::Eq(hn::LoadU(df, axis.at.data() + p * kLanes), first));
      if (there < 0) continue;
      best.bound = p * kLanes + static_cast<std::size_t>(there);
      return;
    }
  }

  /// The references of a set, in order.
  std::span<const kdtree::Reference> list_of(Set set) {
    std::size_t n = 0;
    for (unsigned rest = set; rest != 0; rest &= rest - 1)
      list_[n++] = refs_[static_cast<std::size_t>(std::countr_zero(rest))];
    return std::span(list_).first(n);
  }

  const split::BoundRule& rule_;
  const int max_depth_;
  const std::span<const kdtree::Reference> refs_;
  const PlainTask& task_;
  std::array<Axis, 3> axes_;
  std::array<kdtree::Reference, kSmallList> list_;
};

PlainNode small(const split::BoundRule& rule, int max_depth,
                std::span<const kdtree::Reference> refs, const geometry::Aabb& cell, int depth,
                const PlainTask& task) {
  const auto all = static_cast<Set>((1u << refs.size()) - 1);
  return SmallGrowth(rule, max_depth, refs, task).grow(all, cell, depth);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::published::kd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::published::kd {

HWY_EXPORT(small);

PlainNode grow_small(const split::BoundRule& rule, int max_depth,
                     std::span<const kdtree::Reference> refs, const geometry::Aabb& cell, int depth,
                     const PlainTask& task) {
  return HWY_DYNAMIC_DISPATCH(small)(rule, max_depth, refs, cell, depth, task);
}

}  // namespace sightline::accel::published::kd
#endif  // HWY_ONCE
