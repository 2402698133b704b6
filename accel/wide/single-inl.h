// Takes one ray at a time through a tree: tests eight boxes at once, then the triangles of a block
// at once.
#if defined(SIGHTLINE_WIDE_SINGLE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_SINGLE_INL
#undef SIGHTLINE_WIDE_SINGLE_INL
#else
#define SIGHTLINE_WIDE_SINGLE_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/exact.h"
#include "accel/wide/gather-inl.h"
#include "accel/wide/verdict-inl.h"
#include "accel/wide/walk-inl.h"
#include "accel/wide/walk.h"
#include "accel/wide/wide_tree.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

template <Goal kGoal>
class Single {
 public:
  HWY_INLINE Single(const Walked& walked, std::size_t lane)
      : walked_(walked), packet_(walked.packet), lane_(lane) {
    const FloatRays& rays = packet_.floats;
    const std::uint32_t key = rays.key[lane];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      inverse_[axis] = Boxes::set(rays.inverse[axis][lane]);
      near_[axis] = Boxes::set(rays.near[axis][lane]);
      far_[axis] = Boxes::set(rays.far[axis][lane]);
      first_[axis] = 2 * axis + (key >> axis & 1);
    }
    t_in_ = Boxes::set(rays.t_in[lane]);
    z_ = key >> 3;
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
  }

  struct Entry {
    float t;
    Child at;
  };

  void walk(Child root) {
    const std::uint64_t before = nodes_ + triangles_;
    walk_tree(*this, {0, root});
    walked_.counters.steps += nodes_;
    walked_.counters.tests += triangles_;
    packet_.work[lane_] += static_cast<std::uint32_t>(nodes_ + triangles_ - before);
  }

  HWY_INLINE bool visit_node(Entry& entry, Stack<Entry>& stack) {
    ++nodes_;
    const kdtree::WideNode& node = *entry.at.node();
    const auto near = [&](std::size_t axis) {
      return mul_add(Boxes::load(node.bounds[first_[axis]].data()), inverse_[axis], near_[axis]);
    };
    const auto far = [&](std::size_t axis) {
      return mul_add(Boxes::load(node.bounds[first_[axis] ^ 1].data()), inverse_[axis], far_[axis]);
    };
    const Boxes in = max(max(near(0), near(1)), max(near(2), t_in_));
    const Boxes out =
        min(min(far(0), far(1)), min(far(2), Boxes::set(packet_.floats.t_out[lane_])));
    std::uint32_t met = in <= out;
    if (met == 0) return false;
    const auto first = static_cast<std::size_t>(std::countr_zero(met));
    met &= met - 1;
    const Child parent = entry.at;
    entry.at = parent.child(first);
    if (met == 0) return true;
    alignas(64) std::array<float, kdtree::kWidth> t;
    in.store(t.data());
    entry.t = t[first];
    push_others<kGoal != Goal::kAny>(parent, t, met, entry, stack);
    return true;
  }

  HWY_INLINE bool enter(Entry& entry) {
    entry.at = wide::enter(entry.at, 1u << lane_, walked_.leaf);
    return static_cast<bool>(entry.at);
  }

  static constexpr bool part(const Entry&) { return false; }
  HWY_INLINE bool is_done() const {
    return packet_.stopped || (kGoal == Goal::kAny && (packet_.best->found >> lane_ & 1) != 0);
  }
  HWY_INLINE bool matters(const Entry& entry) const {
    return !(entry.t > packet_.floats.t_out[lane_]);
  }

  void visit_block(Entry entry) {
    const std::uint32_t* const words = entry.at.block();
    const blocks::Block block(words);
    triangles_ += block.triangles;
    const FloatRays& rays = packet_.floats;
    const auto set = [&](const Column<float>& column) { return Floats::set(column[lane_]); };
    const auto axis = [&](std::size_t k) {
      return Floats::load_unaligned(block.x + k * block.vertices);
    };
    const Floats z = mul_sub(axis(z_), set(rays.sign), set(rays.z));
    const Floats x = neg_mul_add(set(rays.shear_x), z, axis(x_) - set(rays.x));
    const Floats y = neg_mul_add(set(rays.shear_y), z, axis(y_) - set(rays.y));
    alignas(64) std::array<std::array<float, 16>, 3> stored;
    if constexpr (Floats::kVectors > 1) {
      x.store(stored[0].data());
      y.store(stored[1].data());
      z.store(stored[2].data());
    }
    std::array<Corner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Gather of(block.corner(k));
      corners[k] = {of(x, stored[0].data()), of(y, stored[1].data()), of(z, stored[2].data())};
    }
    const std::uint32_t all = (2u << (block.triangles - 1)) - 1;
    Verdict verdict;
    if (judge(corners, {set(rays.error), set(rays.low), set(rays.high), set(rays.cull)}, all,
              verdict) &&
        sees(block, verdict))
      take(words, verdict);
  }

 private:
  /// Leaves out the triangles that the ray does not see. Returns whether any pair is possible.
  HWY_INLINE bool sees(const blocks::Block& block, Verdict& verdict) const {
    if (packet_.placed.visible == nullptr) return true;
    for (std::uint32_t left = verdict.possible; left != 0; left &= left - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
      if (seeing(packet_, block.id(i), 1u << lane_) == 0) verdict.possible &= ~(1u << i);
    }
    verdict.certain &= verdict.possible;
    return verdict.possible != 0;
  }

  void take(const std::uint32_t* words, const Verdict& verdict) {
    FloatRays& rays = packet_.floats;
    const Floats low = verdict.depth - verdict.off, high = verdict.depth + verdict.off;
    const std::uint32_t certain = verdict.certain & (low >= Floats::set(rays.sure_low[lane_])) &
                                  (high <= Floats::set(rays.sure_high[lane_]));
    if constexpr (kGoal == Goal::kAny) {
      if (certain != 0) {
        packet_.best->found |= 1u << lane_;
        return;
      }
      for (std::uint32_t left = verdict.possible; left != 0 && !is_done(); left &= left - 1)
        decide(packet_, lane_, words, static_cast<std::uint32_t>(std::countr_zero(left)));
    } else if constexpr (kGoal == Goal::kEvery) {
      const std::uint32_t counted = packet_.sinks[lane_].primitives != nullptr ? certain : 0;
      for (std::uint32_t left = counted; left != 0; left &= left - 1)
        add_certain(packet_, lane_, words, static_cast<std::uint32_t>(std::countr_zero(left)));
      for (std::uint32_t left = verdict.possible & ~counted; left != 0; left &= left - 1)
        decide(packet_, lane_, words, static_cast<std::uint32_t>(std::countr_zero(left)));
    } else {
      alignas(64) std::array<float, 16> from, to;
      low.store(from.data());
      high.store(to.data());
      std::uint32_t open = verdict.possible;
      for (std::uint32_t left = certain; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        if (is_nearer(words, static_cast<std::uint32_t>(i), from[i], to[i])) open &= ~(1u << i);
      }
      const float slack = rays.slack[lane_];
      for (; open != 0; open &= open - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(open));
        // The negation also includes a depth that is NaN, of a triangle of which floats know
        // nothing.
        if (!(from[i] - slack > rays.high[lane_]) && !is_best(blocks::Block(words).id(i)))
          remember(packet_, lane_, words, static_cast<std::uint32_t>(i), from[i] - slack);
      }
    }
  }

  /// Takes a certain hit between two depths as the best candidate if it is nearer. The former best
  /// may still be the nearest, and is then remembered.
  bool is_nearer(const std::uint32_t* words, std::uint32_t triangle, float from, float to) {
    FloatRays& rays = packet_.floats;
    const float slack = rays.slack[lane_];
    if (!(to + slack < rays.high[lane_])) return false;
    lower(to + slack);
    Candidates& all = packet_.candidates;
    const std::uint32_t bit = 1u << lane_;
    if ((all.has_best & bit) != 0 && !(all.best_low[lane_] > rays.high[lane_]))
      remember(packet_, lane_, all.best_block[lane_], all.best_triangle[lane_],
               all.best_low[lane_]);
    all.has_best |= bit;
    all.best_block[lane_] = words;
    all.best_triangle[lane_] = triangle;
    all.best_id[lane_] = blocks::Block(words).id(triangle);
    all.best_low[lane_] = from - slack;
    return true;
  }

  /// Whether the triangle is the best candidate: one that lies in several blocks is met again.
  bool is_best(std::uint32_t id) const {
    const Candidates& all = packet_.candidates;
    return (all.has_best >> lane_ & 1) != 0 && all.best_id[lane_] == id;
  }

  /// Lowers the limits, as there is a hit at this depth or before.
  void lower(float high) {
    FloatRays& rays = packet_.floats;
    if (!(high < rays.high[lane_])) return;
    rays.high[lane_] = high;
    const float t = high * rays.per_depth[lane_];
    rays.t_out[lane_] = std::min(rays.t_out[lane_], t + std::fabs(t) * 0x1p-20f);
  }

  const Walked& walked_;
  Packet& packet_;
  std::size_t lane_;
  std::array<Boxes, 3> inverse_, near_, far_;
  Boxes t_in_;
  std::array<std::size_t, 3> first_;  // by axis: the row of the bounds that the ray meets first
  std::size_t x_, y_, z_;
  std::uint64_t nodes_ = 0, triangles_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
