// Takes rays that run alike through a tree together: tests a box against all of them at once, then
// against each; leaves out triangles that none can meet.
#if defined(SIGHTLINE_WIDE_GROUP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_GROUP_INL
#undef SIGHTLINE_WIDE_GROUP_INL
#else
#define SIGHTLINE_WIDE_GROUP_INL
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/wide/candidates-inl.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/group_bounds-inl.h"
#include "accel/wide/single-inl.h"
#include "accel/wide/walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

template <Goal kGoal>
class Group {
 public:
  /// Where fewer than `together` rays come to a node, each goes on alone.
  HWY_INLINE Group(const Walked& walked, std::uint32_t group, int together)
      : walked_(walked),
        packet_(walked.packet),
        group_(group),
        together_(together),
        boxes_(packet_, group, packet_.extent),
        view_(packet_, group) {
    const FloatRays& rays = packet_.floats;
    const std::uint32_t key = rays.key[static_cast<std::size_t>(std::countr_zero(group))];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row_[axis] = 2 * axis + (key >> axis & 1);
      inverse_[axis] = Floats::load(rays.inverse[axis].data());
      near_[axis] = Floats::load(rays.near[axis].data());
      far_[axis] = Floats::load(rays.far[axis].data());
    }
    t_in_ = Floats::load(rays.t_in.data());
    z_ = key >> 3;
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    read_limits();
  }

  struct Entry {
    float t;
    std::uint32_t lanes;
    Child at;
  };

  void walk(Child root) { walk_tree(*this, {0, group_, root}); }

  HWY_INLINE bool visit_node(Entry& entry, Stack<Entry>& stack) {
    const kdtree::WideNode& node = *entry.at.node();
    walked_.counters.steps += static_cast<std::uint64_t>(std::popcount(entry.lanes));
    count(entry.lanes, 1);
    Boxes in;
    std::uint32_t met = boxes_.met(node, farthest_, in);
    alignas(64) std::array<float, kdtree::kWidth> t;
    in.store(t.data());
    const std::size_t base = stack.size();
    for (; met != 0; met &= met - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(met));
      const std::uint32_t lanes = entry.lanes & meeting(node, i);
      if (lanes == 0) continue;
      const Entry child{t[i], lanes, entry.at.child(i)};
      if constexpr (kGoal == Goal::kAny) {
        stack.push(child);
      } else {
        stack.push_by_distance(child, base);
      }
    }
    if (stack.size() == base) return false;
    entry = stack.pop();
    return true;
  }

  HWY_INLINE bool enter(Entry& entry) {
    entry.at = wide::enter(entry.at, entry.lanes, walked_.leaf);
    if (!entry.at) read_limits();
    return static_cast<bool>(entry.at);
  }

  /// Few rays go on one by one.
  HWY_INLINE bool part(const Entry& entry) {
    if (std::popcount(entry.lanes) >= together_) return false;
    for (std::uint32_t left = entry.lanes; left != 0 && !packet_.stopped; left &= left - 1)
      Single<kGoal>(walked_, static_cast<std::size_t>(std::countr_zero(left))).walk(entry.at);
    read_limits();
    return true;
  }

  HWY_INLINE bool is_done() const { return packet_.stopped; }

  HWY_INLINE bool matters(Entry& entry) const {
    if (entry.t > farthest_) return false;
    entry.lanes &= kGoal == Goal::kAny ? ~packet_.best->found : Floats::set(entry.t) <= t_out_;
    return entry.lanes != 0;
  }

  void visit_block(Entry entry) {
    const std::uint32_t* const words = entry.at.block();
    const blocks::Block block(words);
    walked_.counters.tests +=
        block.triangles * static_cast<std::uint64_t>(std::popcount(entry.lanes));
    count(entry.lanes, block.triangles);
    const float *x = block.x + x_ * block.vertices, *y = block.x + y_ * block.vertices,
                *z = block.x + z_ * block.vertices;
    // For fewer triangles, finding which to leave out takes as long as testing them.
    constexpr unsigned kMany = 3;
    std::uint32_t left = block.triangles < kMany ? (2u << (block.triangles - 1)) - 1
                                                 : view_.possible(block, x, y, z);
    bool nearer = false;
    for (; left != 0 && entry.lanes != 0; left &= left - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
      std::array<Corner, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t v = block.corner(k)[i];
        corners[k] = seen(x[v], y[v], z[v]);
      }
      const FloatRays& rays = packet_.floats;
      const auto load = [](const Column<float>& column) { return Floats::load(column.data()); };
      Verdict verdict;
      if (!judge(corners, {load(rays.error), load(rays.low), load(rays.high), load(rays.cull)},
                 seeing(packet_, block.id(i), entry.lanes), verdict))
        continue;
      nearer |= take(words, i, verdict);
      if constexpr (kGoal == Goal::kAny) entry.lanes &= ~packet_.best->found;
    }
    if (!nearer) return;
    if constexpr (kGoal == Goal::kEvery) {
      read_limits();
    } else {
      lower_t_out();
    }
  }

 private:
  /// Reads the limits of the rays, which others may have lowered.
  HWY_INLINE void read_limits() {
    t_out_ = Floats::load(packet_.floats.t_out.data());
    farthest_ = range_of(packet_.floats.t_out, group_).hi;
  }

  HWY_INLINE void count(std::uint32_t lanes, std::uint32_t work) {
    using Counts = Lanes<std::uint32_t, kLanes>;
    const Counts before = Counts::load(packet_.work.data());
    Counts::pick(lanes, before + Counts::set(work), before).store(packet_.work.data());
  }

  /// The rays that meet one child.
  HWY_INLINE std::uint32_t meeting(const kdtree::WideNode& node, std::size_t i) const {
    const auto near = [&](std::size_t axis) {
      return mul_add(Floats::set(node.bounds[row_[axis]][i]), inverse_[axis], near_[axis]);
    };
    const auto far = [&](std::size_t axis) {
      return mul_add(Floats::set(node.bounds[row_[axis] ^ 1][i]), inverse_[axis], far_[axis]);
    };
    const Floats in = max(max(near(0), near(1)), max(near(2), t_in_));
    const Floats out = min(min(far(0), far(1)), min(far(2), t_out_));
    return in <= out;
  }

  /// Takes a verdict by the goal. Returns whether some ray's limits were lowered.
  HWY_INLINE bool take(const std::uint32_t* words, std::uint32_t triangle, const Verdict& verdict) {
    if constexpr (kGoal == Goal::kAny) {
      find(packet_, words, triangle, verdict);
      return false;
    } else if constexpr (kGoal == Goal::kEvery) {
      return offer_every(packet_, words, triangle, verdict);
    } else {
      return add_candidates(packet_, words, triangle, verdict);
    }
  }

  HWY_INLINE Corner seen(float x, float y, float z) const {
    const FloatRays& rays = packet_.floats;
    const auto load = [](const Column<float>& column) { return Floats::load(column.data()); };
    Corner corner;
    corner.z = mul_sub(Floats::set(z), load(rays.sign), load(rays.z));
    corner.x = neg_mul_add(load(rays.shear_x), corner.z, Floats::set(x) - load(rays.x));
    corner.y = neg_mul_add(load(rays.shear_y), corner.z, Floats::set(y) - load(rays.y));
    return corner;
  }

  void lower_t_out() {
    FloatRays& rays = packet_.floats;
    const Floats t = Floats::load(rays.high.data()) * Floats::load(rays.per_depth.data());
    t_out_ = min(t_out_, mul_add(abs(t), Floats::set(0x1p-20f), t));
    t_out_.store(rays.t_out.data());
    farthest_ = range_of(rays.t_out, group_).hi;
  }

  const Walked& walked_;
  Packet& packet_;
  const std::uint32_t group_;
  const int together_;
  const GroupBoxes boxes_;
  const GroupView view_;
  std::array<Floats, 3> inverse_, near_, far_;
  Floats t_in_, t_out_;
  float farthest_ = 0;
  std::array<std::size_t, 3> row_;  // by axis: the row of the bounds that the rays meet first
  std::size_t x_, y_, z_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
