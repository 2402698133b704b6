#include "tests/fuzz/verdict/check_verdicts.h"

#include <array>
#include <bit>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <hwy/targets.h>

#include "accel/blocks/block.h"
#include "accel/geometry/intersect.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/walk.h"
#include "tests/fuzz/verdict/check_flat.h"
#include "tests/fuzz/verdict/check_packets.h"
#include "tests/fuzz/verdict/exact_answers.h"
#include "tests/fuzz/verdict/float_verdicts.h"
#include "tests/fuzz/verdict/verdict_tree.h"

namespace sightline::tests {

using accel::geometry::Aabb;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
namespace wide = accel::wide;

namespace {

/// Calls f(lane) for each bit.
template <class F>
void each_lane(std::uint32_t lanes, const F& f) {
  for (; lanes != 0; lanes &= lanes - 1) f(static_cast<std::size_t>(std::countr_zero(lanes)));
}

class VerdictCheck {
 public:
  VerdictCheck(const VerdictCase& asked, const VerdictTree& tree, const ExactAnswers& exact,
               VerdictTally& tally)
      : asked_(asked), tree_(tree), exact_(exact), tally_(tally) {
    live_ = prepare_packet(asked, tree, false, packet_);
  }

  void run() {
    check_bounds();
    check_boxes();
    check_pairs();
    check_groups();
  }

  std::optional<std::string> finding;

 private:
  void expect(bool holds, const char* what, std::size_t lane, std::size_t face) {
    if (!holds && !finding) finding = fmt::format("{}: ray {}, triangle {}", what, lane, face);
  }

  template <class F>
  void each_counting(std::uint32_t lanes, const F& f) {
    each_lane(lanes, [&](std::size_t lane) {
      for (std::size_t face = 0; face < asked_.faces.size(); ++face) {
        if (exact_.counts(lane, face)) f(lane, face, *exact_.pair(lane, face).local);
      }
    });
  }

  const wide::FloatRays& floats() const { return packet_.packet->floats; }
  std::size_t main_axis(std::size_t lane) const { return floats().key[lane] >> 3; }

  /// t as floats count it, and how far that may be off the exact hit: near by, less than planes
  /// are.
  double in_floats(std::size_t lane, double t) const { return t - floats().shift[lane]; }
  double off(std::size_t lane, std::size_t face) const {
    return floats().shift[lane] == 0 ? 0
                                     : accel::geometry::kHitError * exact_.pair(lane, face).reach;
  }

  /// No hit is outside of where the ray may meet the tree.
  void check_bounds() {
    const auto all = static_cast<std::uint32_t>((1u << asked_.rays.size()) - 1);
    each_counting(all, [&](std::size_t lane, std::size_t face, double t) {
      expect((live_ >> lane & 1) != 0, "a ray with a hit is not live", lane, face);
      const double at = in_floats(lane, t), rest = off(lane, face);
      expect(static_cast<double>(floats().t_in[lane]) <= at + rest, "enters behind a hit", lane,
             face);
      expect(static_cast<double>(floats().t_out[lane]) >= at - rest, "leaves before a hit", lane,
             face);
    });
  }

  /// The least box of floats that certainly holds a hit.
  Aabb box_around(std::size_t lane, std::size_t face, double t) const {
    const accel::geometry::LocalRay& ray = exact_.ray(lane);
    Aabb box = tree_.box(face);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double o = ray.origin[axis] - static_cast<double>(tree_.frame().center[axis]);
      const double x = o + t * ray.direction[axis];
      const double off = 4 * accel::geometry::kHitError * exact_.pair(lane, face).reach +
                         0x1p-50 * (std::fabs(o) + std::fabs(x));
      box.lo[axis] = std::max(box.lo[axis], accel::geometry::round_down(x - off));
      box.hi[axis] = std::min(box.hi[axis], accel::geometry::round_up(x + off));
    }
    return box;
  }

  void check_boxes() {
    each_counting(live_, [&](std::size_t lane, std::size_t face, double t) {
      for (const Aabb& box : {tree_.box(face), box_around(lane, face, t)}) {
        expect(meeting(*packet_.packet, box, live_) >> lane & 1, "misses the box of a hit", lane,
               face);
        accel::kdtree::WideNode node;  // with one child, which is never visited
        node.set_box(0, box);
        for (const std::uint32_t group : {1u << lane, alike(lane)}) {
          const GroupMeeting meeting = meet(*packet_.packet, group, node);
          expect(meeting.met & 1, "a group misses the box of a hit", lane, face);
          expect(static_cast<double>(meeting.in[0]) <= in_floats(lane, t) + off(lane, face),
                 "a group enters behind a hit", lane, face);
          expect((meeting.met & ~1u) == 0, "a group meets what does not exist", lane, face);
        }
      }
    });
  }

  std::uint32_t alike(std::size_t lane) const {
    std::uint32_t group = 0;
    each_lane(live_, [&](std::size_t other) {
      if (floats().key[other] == floats().key[lane]) group |= 1u << other;
    });
    return group;
  }

  void check_pairs() {
    for (std::size_t face = 0; face < asked_.faces.size(); ++face) {
      const FloatVerdicts verdicts = judge(*packet_.packet, tree_.corners(face), live_);
      each_lane(live_, [&](std::size_t lane) { check_pair(lane, face, verdicts); });
    }
  }

  void check_pair(std::size_t lane, std::size_t face, const FloatVerdicts& verdicts) {
    const ExactPair& exact = exact_.pair(lane, face);
    const bool possible = verdicts.possible >> lane & 1, certain = verdicts.certain >> lane & 1;
    ++tally_.pairs;
    tally_.hits += exact.local ? 1 : 0;
    tally_.sure_misses += possible ? 0 : 1;
    tally_.sure_hits += certain ? 1 : 0;
    expect(possible || !exact_.counts(lane, face), "a hit as a certain miss", lane, face);
    expect(!certain || exact.local, "a miss as a certain hit", lane, face);
    expect(!certain || !exact.culled, "a culled hit as a certain hit", lane, face);
    if (!possible || !exact.local) return;
    const float depth = verdicts.depth[lane], off = verdicts.off[lane];
    const bool sure =
        depth - off >= floats().sure_low[lane] && depth + off <= floats().sure_high[lane];
    expect(!(certain && sure) || exact.in_limits, "a hit outside of the limits as one inside", lane,
           face);
    check_depth(lane, face, static_cast<double>(depth), static_cast<double>(off));
  }

  /// A depth that is not a number says nothing.
  void check_depth(std::size_t lane, std::size_t face, double depth, double off) {
    const accel::geometry::LocalRay& ray = exact_.ray(lane);
    const std::size_t z = main_axis(lane);
    const double along = std::fabs(ray.direction[z]), shift = floats().shift[lane];
    const double exact = (*exact_.pair(lane, face).local - shift) * along;
    const double slack = static_cast<double>(floats().slack[lane]);
    expect(!(std::fabs(depth - exact) > off + slack), "a depth beyond its bound", lane, face);
    // The ray of floats begins elsewhere.
    const double o = ray.origin[z] - static_cast<double>(tree_.frame().center[z]),
                 sign = static_cast<double>(floats().sign[lane]);
    const double from_float =
        exact + (o * sign + shift * along - static_cast<double>(floats().z[lane]));
    const double rest = 2 * accel::geometry::kHitError * exact_.pair(lane, face).reach +
                        0x1p-50 * (std::fabs(o) + std::fabs(exact)) +
                        static_cast<double>(floats().off[lane] + wide::kTiny);
    expect(!(std::fabs(depth - from_float) > off + rest), "a depth beyond the triangle's bound",
           lane, face);
  }

  void check_groups() {
    for (std::uint32_t left = live_; left != 0;) {
      const std::uint32_t group = alike(static_cast<std::size_t>(std::countr_zero(left)));
      left &= ~group;
      tally_.groups += std::popcount(group) > 1 ? 1 : 0;
      for (const std::uint32_t* words : tree_.blocks()) {
        check_view(group, words);
        each_lane(group, [&](std::size_t lane) { check_view(1u << lane, words); });
      }
    }
  }

  /// A triangle that a group leaves out is met by none of its rays, at any t.
  void check_view(std::uint32_t group, const std::uint32_t* words) {
    const accel::blocks::Block block(words);
    const std::uint32_t seen = possible(*packet_.packet, group, words);
    for (std::uint32_t i = 0; i < block.triangles; ++i) {
      if ((seen >> i & 1) != 0) continue;
      each_lane(group, [&](std::size_t lane) {
        expect(!exact_.pair(lane, block.id(i)).local, "a group leaves out a hit", lane,
               block.id(i));
      });
    }
    expect((seen >> block.triangles) == 0, "a group sees what does not exist", 0, 0);
  }

  const VerdictCase& asked_;
  const VerdictTree& tree_;
  const ExactAnswers& exact_;
  VerdictTally& tally_;
  PreparedPacket packet_;
  std::uint32_t live_ = 0;
};

std::optional<std::string> check_verdicts(const VerdictCase& asked, VerdictTally& tally) {
  const VerdictTree tree(asked.view());
  if (!tree.is_made()) return std::nullopt;
  const ExactAnswers exact(asked);
  ++tally.packets;
  VerdictCheck check(asked, tree, exact, tally);
  check.run();
  if (check.finding) return check.finding;
  if (auto wrong = check_packets(asked, tree, exact)) return wrong;
  bool is_flat = false;
  auto wrong = check_flat(asked, is_flat);
  tally.flat += is_flat ? 1 : 0;
  return wrong;
}

}  // namespace

std::optional<std::string> check_on_target(std::size_t target, const VerdictCase& asked,
                                           VerdictTally& tally) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  const std::int64_t chosen = targets[target % targets.size()];
  hwy::SetSupportedTargetsForTest(chosen);
  const std::optional<std::string> finding = check_verdicts(asked, tally);
  hwy::SetSupportedTargetsForTest(0);
  if (!finding) return finding;
  return fmt::format("{}, {}", hwy::TargetName(chosen), *finding);
}

std::optional<std::string> check_on_every_target(const VerdictCase& asked, VerdictTally& tally) {
  for (std::size_t i = 0; i < hwy::SupportedAndGeneratedTargets().size(); ++i) {
    if (auto finding = check_on_target(i, asked, tally)) return finding;
  }
  return std::nullopt;
}

}  // namespace sightline::tests
