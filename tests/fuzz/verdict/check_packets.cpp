#include "tests/fuzz/verdict/check_packets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "accel/blocks/block.h"
#include "accel/geometry/intersect.h"
#include "accel/wide/exact.h"
#include "accel/wide/walk.h"

namespace sightline::tests {

namespace wide = accel::wide;

namespace {

/// Leaf policy of trees of nodes and blocks.
struct NothingElse {
  static wide::Child enter(accel::kdtree::AtomicSlot&, std::uint32_t) { return {}; }
  static void visit(std::span<const std::uint32_t>, std::uint32_t) {}
};

/// What a walk has left in a packet, against the rule.
class PacketCheck {
 public:
  PacketCheck(const ExactAnswers& exact, const PreparedPacket& packet, bool any)
      : exact_(exact), packet_(*packet.packet), best_(*packet.best), any_(any) {}

  /// Before candidates are decided: the best certain hit is one, at a depth in its interval.
  std::optional<std::string> check_certain(std::size_t lane) const {
    const wide::Candidates& all = packet_.candidates;
    if (any_ || (all.has_best >> lane & 1) == 0) return std::nullopt;
    const std::uint32_t face =
        accel::blocks::Block(all.best_block[lane]).id(all.best_triangle[lane]);
    const ExactPair& pair = exact_.pair(lane, face);
    if (!pair.local || pair.culled || !pair.in_limits) return "no hit as the nearest";
    const std::size_t z = packet_.floats.key[lane] >> 3;
    const double depth =
        (*pair.local - packet_.floats.shift[lane]) * std::fabs(exact_.ray(lane).direction[z]);
    if (depth < static_cast<double>(all.best_low[lane])) return "the nearest before its interval";
    if (depth > static_cast<double>(packet_.floats.high[lane]))
      return "the nearest behind its interval";
    return check_limits(lane, *pair.local, exact_.reach(lane));
  }

  std::optional<std::string> check_answer(std::size_t lane) const {
    const bool found = best_.found >> lane & 1;
    const ExactBest expected = exact_.best(lane, any_);
    if (found != expected.found) return found ? "finds a miss" : "misses a hit";
    if (any_ || !found) return std::nullopt;
    const ExactBest answer{true, best_.t[lane], best_.node[lane], best_.primitive[lane]};
    if (!(answer == expected))
      return fmt::format("answers t {:a}, node {}, triangle {}, not t {:a}, node {}, triangle {}",
                         answer.t, answer.node, answer.primitive, expected.t, expected.node,
                         expected.primitive);
    return check_limits(lane, answer.t / exact_.ray(lane).unit, exact_.reach(lane));
  }

 private:
  /// What may still be met includes the best hit itself, so that equal ones are; where a ray begins
  /// far away, the exact one.
  std::optional<std::string> check_limits(std::size_t lane, double t, double reach) const {
    const double shift = packet_.floats.shift[lane];
    const double off = shift == 0 ? 0 : accel::geometry::kHitError * reach;
    if (t - shift - off > static_cast<double>(packet_.floats.t_out[lane]))
      return "t_out before the best hit";
    return std::nullopt;
  }

  const ExactAnswers& exact_;
  const wide::Packet& packet_;
  const wide::BestHits& best_;
  const bool any_;
};

void walk(wide::Packet& packet, wide::Child root, std::uint32_t lanes) {
  NothingElse none;
  accel::kdtree::WalkCounters walked;
  wide::walk(packet, root, lanes, wide::Leaf(none), walked);
}

std::optional<std::string> walk_and_check(const VerdictCase& asked, const VerdictTree& tree,
                                          const wide::WideTree& walked, const ExactAnswers& exact,
                                          std::uint32_t lanes, bool any) {
  PreparedPacket packet;
  prepare_packet(asked, tree, any, packet);
  const std::uint32_t live = prepare(*packet.packet, tree.frame(), lanes);
  const PacketCheck check(exact, packet, any);
  walk(*packet.packet, wide::Child::final(walked.root()), live);
  const auto each = [&](auto test) -> std::optional<std::string> {
    for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      if (const std::optional<std::string> wrong = test(lane))
        return fmt::format("{} ray{}, {} hit: ray {}: {}", std::popcount(lanes),
                           std::popcount(lanes) == 1 ? "" : "s", any ? "any" : "nearest", lane,
                           *wrong);
    }
    return std::nullopt;
  };
  if (const auto wrong = each([&](std::size_t lane) { return check.check_certain(lane); }))
    return wrong;
  if (!any) wide::resolve(*packet.packet, live);
  return each([&](std::size_t lane) { return check.check_answer(lane); });
}

/// Every hit of these rays: listed up to the hits that they come with, or counted.
std::optional<std::string> check_every(const VerdictCase& asked, const VerdictTree& tree,
                                       const ExactAnswers& exact, std::uint32_t lanes,
                                       bool counts) {
  PreparedPacket packet;
  const std::uint32_t live = prepare_packet(asked, tree, counts, packet);
  std::array<wide::UniqueHits<wide::ListedHit>, wide::kLanes> lists;
  std::array<wide::UniqueHits<std::uint32_t>, wide::kLanes> primitives;
  std::array<wide::HitSink, wide::kLanes> sinks;
  for (std::size_t lane = 0; lane < wide::kLanes; ++lane) {
    sinks[lane] = counts ? wide::HitSink{.primitives = &primitives[lane]}
                         : wide::HitSink{.list = &lists[lane]};
  }
  packet.packet->goal = wide::Goal::kEvery;
  packet.packet->sinks = sinks;
  walk(*packet.packet, wide::Child::final(tree.single().root()), live & lanes);
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    std::vector<std::uint32_t> found(primitives[lane].sorted().begin(),
                                     primitives[lane].sorted().end());
    for (const wide::ListedHit& hit : lists[lane].sorted()) {
      if (hit.t != exact.pair(lane, hit.primitive).world)
        return fmt::format("every hit: ray {}: t of triangle {}", lane, hit.primitive);
      found.push_back(hit.primitive);
    }
    for (std::uint32_t face = 0; face < asked.faces.size(); ++face) {
      const ExactPair& pair = exact.pair(lane, face);
      const bool expected =
          counts ? pair.local && !pair.culled && pair.in_limits && std::isfinite(pair.world)
                 : exact.counts(lane, face);
      if (expected != (std::ranges::count(found, face) == 1))
        return fmt::format("every hit: ray {}: triangle {}", lane, face);
    }
  }
  return std::nullopt;
}

}  // namespace

std::uint32_t prepare_packet(const VerdictCase& asked, const VerdictTree& tree, bool any,
                             PreparedPacket& out) {
  wide::Packet& packet = *out.packet;
  wide::BestHits& best = *out.best;
  best.clear();
  packet.best = &best;
  packet.goal = any ? wide::Goal::kAny : wide::Goal::kNearest;
  packet.culling = asked.culling;
  packet.node = kAskedNode;
  packet.work.fill(0);
  for (std::size_t lane = 0; lane < wide::kLanes; ++lane) {
    const AskedRay& ray = asked.rays[std::min(lane, asked.rays.size() - 1)];
    const auto local = *accel::geometry::make_local_ray(ray.ray.origin, ray.ray.direction);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      packet.rays.origin[axis][lane] = local.origin[axis];
      packet.rays.direction[axis][lane] = local.direction[axis];
    }
    packet.rays.unit[lane] = local.unit;
    packet.rays.tmin[lane] = ray.ray.tmin;
    packet.rays.tmax[lane] = ray.ray.tmax;
    if (any || !ray.has_best || lane >= asked.rays.size()) continue;
    best.t[lane] = ray.best_t;
    best.node[lane] = ray.best_node;
    best.primitive[lane] = kBestBefore;
    best.found |= 1u << lane;
  }
  return prepare(packet, tree.frame(), static_cast<std::uint32_t>((1u << asked.rays.size()) - 1));
}

std::optional<std::string> check_packets(const VerdictCase& asked, const VerdictTree& tree,
                                         const ExactAnswers& exact) {
  const auto all = static_cast<std::uint32_t>((1u << asked.rays.size()) - 1);
  for (const wide::WideTree* walked : {&tree.single(), &tree.dense()}) {
    for (const bool any : {false, true}) {
      if (auto wrong = walk_and_check(asked, tree, *walked, exact, all, any)) return wrong;
      for (std::uint32_t left = all; left != 0; left &= left - 1) {
        const std::uint32_t lane = left & (~left + 1);
        if (auto wrong = walk_and_check(asked, tree, *walked, exact, lane, any)) return wrong;
      }
    }
  }
  for (const bool counts : {false, true}) {
    if (auto wrong = check_every(asked, tree, exact, all, counts)) return wrong;
    for (std::uint32_t left = all; left != 0; left &= left - 1) {
      if (auto wrong = check_every(asked, tree, exact, left & (~left + 1), counts)) return wrong;
    }
  }
  return std::nullopt;
}

}  // namespace sightline::tests
