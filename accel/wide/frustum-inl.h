// The walk of a frustum. docs/hit_rule.md, section 8, derives the constants.
#if defined(SIGHTLINE_WIDE_FRUSTUM_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_FRUSTUM_INL
#undef SIGHTLINE_WIDE_FRUSTUM_INL
#else
#define SIGHTLINE_WIDE_FRUSTUM_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/candidates-inl.h"
#include "accel/wide/frustum_planes-inl.h"
#include "accel/wide/frustum_rays-inl.h"
#include "accel/wide/walk-inl.h"
#include "accel/wide/wide_tree.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// The boxes that a frustum may meet.
class FrustumBoxes {
 public:
  HWY_INLINE FrustumBoxes(const FrustumRays& rays, float extent) {
    const Point& point = rays.point;
    float farthest = 0;
    for (const double at : point.at)
      farthest = std::max(farthest, std::fabs(static_cast<float>(at)));
    const float reach = 0x1p-4f * static_cast<float>(point.reach);
    const float error = (extent + 2 * farthest + reach) * 0x1p-23f + (4 * point.error + kTiny);
    error_ = Boxes::set(error);
    for (std::size_t k = 0; k < 2; ++k) {
      row_[k] = 2 * point.axis[k];
      const auto at = static_cast<float>(point.at[k]);
      at_less_[k] = Boxes::set(at - error);
      at_more_[k] = Boxes::set(at + error);
      const auto slope = static_cast<float>(point.slope[k]);
      const float off =
          0x1p-21f * (std::fabs(slope) + std::max(-rays.spread_lo[k], rays.spread_hi[k]));
      lo_[k] = Boxes::set(slope + rays.spread_lo[k] - off);
      hi_[k] = Boxes::set(slope + rays.spread_hi[k] + off);
    }
    near_row_ = 2 * point.axis[2] + (point.sign < 0 ? 1 : 0);
    main_at_ = Boxes::set(static_cast<float>(point.at[2]));
    sign_ = Boxes::set(point.sign);
  }

  /// Returns the children that some ray may meet between two depths; sets where they begin.
  HWY_INLINE std::uint32_t met(const kdtree::WideNode& node, float nearest, float farthest,
                               Boxes& begin) const {
    const Boxes zero = Boxes::set(0);
    begin = max((Boxes::load(node.bounds[near_row_].data()) - main_at_) * sign_ - error_, zero);
    const Boxes end = (Boxes::load(node.bounds[near_row_ ^ 1].data()) - main_at_) * sign_ + error_;
    return (begin <= end) & (begin <= Boxes::set(farthest)) & (end >= Boxes::set(nearest)) &
           beside(node, 0, begin, end) & beside(node, 1, begin, end);
  }

 private:
  /// The children that do not lie wholly to one side of all rays, along axis k.
  HWY_INLINE std::uint32_t beside(const kdtree::WideNode& node, std::size_t k, const Boxes& begin,
                                  const Boxes& end) const {
    const Boxes lo = Boxes::load(node.bounds[row_[k]].data()) - at_more_[k],
                hi = Boxes::load(node.bounds[row_[k] + 1].data()) - at_less_[k];
    return (max(hi_[k] * begin, hi_[k] * end) >= lo) & (min(lo_[k] * begin, lo_[k] * end) <= hi);
  }

  std::array<Boxes, 2> at_less_, at_more_, lo_, hi_;
  Boxes error_, main_at_, sign_;
  std::array<std::size_t, 2> row_;
  std::size_t near_row_;
};

template <bool kAny>
class Frustum {
 public:
  HWY_INLINE Frustum(std::span<Packet> packets, const FrustumRays& rays, const Frame& frame,
                     const FrustumLanes& lanes, kdtree::WalkCounters& counters)
      : packets_(packets),
        lanes_(lanes),
        counters_(counters),
        boxes_(rays, largest_coordinate(frame.bounds)),
        planes_(rays) {
    low_.fill(std::numeric_limits<float>::max());
    high_.fill(-std::numeric_limits<float>::max());
    for (std::size_t p = 0; p < kFrustumPackets; ++p) {
      const FloatRays& floats = packets[std::min(p, packets.size() - 1)].floats;
      slopes_x_[p] = floats.shear_x;
      slopes_y_[p] = floats.shear_y;
      if (lanes[p] != 0) read_depths(p);
    }
    set_range();
  }

  struct Entry {
    float t;  // a depth
    Child at;
  };

  /// Returns false if the rays come to a cell that is not built, or to too many blocks.
  HWY_INLINE bool walk(Child root) {
    walk_tree(*this, {0, root});
    if (gave_up_) return false;
    count_work();
    return true;
  }

  HWY_INLINE bool visit_node(Entry& entry, Stack<Entry>& stack) {
    ++nodes_;
    const kdtree::WideNode& node = *entry.at.node();
    Boxes begin;
    std::uint32_t met = boxes_.met(node, nearest_, farthest_, begin);
    if (met == 0) return false;
    alignas(64) std::array<float, kdtree::kWidth> depth;
    begin.store(depth.data());
    const std::size_t base = stack.size();
    for (; met != 0; met &= met - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(met));
      stack.push_by_distance({depth[i], entry.at.child(i)}, base);
    }
    entry = stack.pop();
    return true;
  }

  HWY_INLINE bool enter(Entry& entry) {
    if (entry.at.is_list()) return false;  // which is empty
    const kdtree::Slot now = kdtree::load(entry.at.slot());
    gave_up_ = !now.is_finished();
    if (!gave_up_) entry.at = Child::final(static_cast<const WideTree*>(now.finished())->enter());
    return !gave_up_;
  }

  static constexpr bool part(const Entry&) { return false; }
  HWY_INLINE bool is_done() const {
    if (gave_up_) return true;
    if constexpr (!kAny) return false;
    std::uint32_t left = 0;
    for (const std::uint32_t lanes : lanes_) left |= lanes;
    return left == 0;
  }
  HWY_INLINE bool matters(const Entry& entry) const { return !(entry.t > farthest_); }

  void visit_block(Entry entry) {
    gave_up_ = ++blocks_ > kMostBlocks;
    if (gave_up_) return;
    const std::uint32_t* const words = entry.at.block();
    const blocks::Block block(words);
    triangles_ += block.triangles;
    std::uint32_t left = planes_.set(block, nearest_, farthest_);
    std::uint32_t lowered = 0;
    for (; left != 0; left &= left - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
      // All packets are tested at once, so that none waits for another's branch.
      std::array<std::uint32_t, kFrustumPackets> possible;
      for (std::size_t p = 0; p < kFrustumPackets; ++p)
        possible[p] = lanes_[p] & planes_.met(i, Floats::load(slopes_x_[p].data()),
                                              Floats::load(slopes_y_[p].data()));
      if ((possible[0] | possible[1] | possible[2] | possible[3]) == 0) continue;
      for (std::size_t p = 0; p < kFrustumPackets; ++p) {
        if (possible[p] != 0 && test(p, possible[p], words, i)) lowered |= 1u << p;
      }
      if (kAny && is_done()) return;
    }
    if (lowered == 0) return;
    for (; lowered != 0; lowered &= lowered - 1)
      read_depths(static_cast<std::size_t>(std::countr_zero(lowered)));
    set_range();
  }

 private:
  /// A frustum meets at most this number of blocks; most of any others would be met by few of its
  /// rays.
  static constexpr std::size_t kMostBlocks = 32;

  /// Decides a triangle for rays that may meet it. Returns whether the depths that matter have
  /// changed.
  HWY_INLINE bool test(std::size_t p, std::uint32_t lanes, const std::uint32_t* words,
                       std::uint32_t i) {
    Packet& packet = packets_[p];
    const FloatRays& rays = packet.floats;
    const auto load = [](const Column<float>& column) { return Floats::load(column.data()); };
    Verdict verdict;
    if (!judge(planes_.edges(i, load(rays.shear_x), load(rays.shear_y)),
               {Floats::set(0), load(rays.low), load(rays.high), load(rays.cull)}, lanes, verdict))
      return false;
    if constexpr (kAny) {
      find(packet, words, i, verdict);
      const std::uint32_t before = lanes_[p];
      lanes_[p] &= ~packet.best->found;
      return lanes_[p] != before;
    } else {
      return add_candidates(packet, words, i, verdict);
    }
  }

  /// Reads the depths that matter to a packet.
  HWY_INLINE void read_depths(std::size_t p) {
    const FloatRays& rays = packets_[p].floats;
    const Floats most = Floats::set(std::numeric_limits<float>::max());
    low_[p] = Floats::pick(lanes_[p], Floats::load(rays.low.data()), most).least();
    high_[p] = Floats::pick(lanes_[p], Floats::load(rays.high.data()), neg(most)).greatest();
  }

  HWY_INLINE void set_range() {
    nearest_ = *std::min_element(low_.begin(), low_.end());
    farthest_ = *std::max_element(high_.begin(), high_.end());
  }

  void count_work() {
    using Counts = Lanes<std::uint32_t, kLanes>;
    std::uint64_t rays = 0;
    const Counts work = Counts::set(nodes_ + triangles_);
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      rays += static_cast<std::uint64_t>(std::popcount(group_[p]));
      (Counts::load(packets_[p].work.data()) + work).store(packets_[p].work.data());
    }
    counters_.steps += nodes_ * rays;
    counters_.tests += triangles_ * rays;
  }

  std::span<Packet> packets_;
  FrustumLanes lanes_;
  const FrustumLanes group_ = lanes_;
  kdtree::WalkCounters& counters_;
  const FrustumBoxes boxes_;
  FrustumPlanes planes_;
  std::array<float, kFrustumPackets> low_, high_;
  std::array<Column<float>, kFrustumPackets> slopes_x_, slopes_y_;
  float nearest_ = 0, farthest_ = 0;
  std::size_t blocks_ = 0;
  bool gave_up_ = false;
  std::uint32_t nodes_ = 0, triangles_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
