// Takes packets of up to sixteen rays whose directions agree through a tree, and single rays and
// points elsewhere.
#include "accel/wide/walk.h"

#include <array>
#include <bit>
#include <cmath>

#include "accel/blocks/block.h"
#include "accel/wide/exact.h"
#include "accel/wide/float_points.h"
#include "accel/wide/wide_tree.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/walk.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/group-inl.h"
#include "accel/wide/point-inl.h"
#include "accel/wide/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// At least this number of rays visit a node together; fewer go on alone.
constexpr int kTogether = 4;

/// The rays whose directions agree in their signs and largest component with the first one's.
HWY_INLINE std::uint32_t alike(const Packet& packet, std::uint32_t lanes) {
  using Keys = Lanes<std::uint32_t, kLanes>;
  const std::uint32_t key = packet.floats.key[static_cast<std::size_t>(std::countr_zero(lanes))];
  return lanes & equal(Keys::load(packet.floats.key.data()), Keys::set(key));
}

/// Each point walks alone, but begins with what is known of the one before.
template <Goal kGoal>
void walk_points(const Walked& walked, Child root, std::uint32_t lanes) {
  std::size_t before = kLanes;
  geometry::Vec3f landmark = Point<kGoal>::nowhere();
  for (; lanes != 0 && !walked.packet.stopped; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    Point<kGoal> point(walked, lane);
    if (kGoal == Goal::kNearest && walked.packet.near.alike && before != kLanes) {
      point.limit_by(before);
      point.limit_by(landmark);
    }
    point.walk(root);
    before = lane;
    if (point.landmark() != Point<kGoal>::nowhere()) landmark = point.landmark();
  }
}

template <Goal kGoal>
void walk_lanes(const Walked& walked, Child root, std::uint32_t lanes) {
  if (walked.packet.points != nullptr) return walk_points<kGoal>(walked, root, lanes);
  while (lanes != 0 && !walked.packet.stopped) {
    std::uint32_t group = alike(walked.packet, lanes);
    lanes &= ~group;
    if (std::popcount(group) >= kTogether) {
      Group<kGoal>(walked, group, kTogether).walk(root);
      continue;
    }
    for (; group != 0 && !walked.packet.stopped; group &= group - 1)
      Single<kGoal>(walked, static_cast<std::size_t>(std::countr_zero(group))).walk(root);
  }
}

std::uint32_t meeting_box(const Packet& packet, const geometry::Aabb& box) {
  const FloatRays& rays = packet.floats;
  Floats in = Floats::load(rays.t_in.data()), out = Floats::load(rays.t_out.data());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Floats inverse = Floats::load(rays.inverse[axis].data()), zero = Floats::set(0);
    const std::uint32_t backward = inverse < zero;
    const Floats lo = Floats::set(box.lo[axis]), hi = Floats::set(box.hi[axis]);
    in = max(
        in, mul_add(Floats::pick(backward, hi, lo), inverse, Floats::load(rays.near[axis].data())));
    out = min(
        out, mul_add(Floats::pick(backward, lo, hi), inverse, Floats::load(rays.far[axis].data())));
  }
  return in <= out;
}

void walk_packet(const Walked& walked, Child root, std::uint32_t lanes) {
  switch (walked.packet.goal) {
    case Goal::kNearest:
      return walk_lanes<Goal::kNearest>(walked, root, lanes);
    case Goal::kAny:
      return walk_lanes<Goal::kAny>(walked, root, lanes);
    case Goal::kEvery:
      return walk_lanes<Goal::kEvery>(walked, root, lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(walk_packet);
HWY_EXPORT(meeting_box);

std::uint32_t meeting(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes) {
  if (packet.points != nullptr) return near_box(packet, box, lanes);
  return lanes & HWY_DYNAMIC_DISPATCH(meeting_box)(packet, box);
}

void walk(Packet& packet, Child root, std::uint32_t lanes, const Leaf& leaf,
          kdtree::WalkCounters& counters) {
  // Slots that are not finished are entered before the rays part into groups.
  while (root && !root.is_node() && !root.is_block()) root = enter(root, lanes, leaf);
  if (!root) return;
  HWY_DYNAMIC_DISPATCH(walk_packet)({packet, leaf, counters}, root, lanes);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
