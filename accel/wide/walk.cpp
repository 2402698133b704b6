// Packets of up to sixteen rays where their directions agree, and single rays elsewhere.
#include "accel/wide/walk.h"

#include <array>
#include <bit>
#include <cmath>

#include "accel/blocks/block.h"
#include "accel/wide/exact.h"
#include "accel/wide/wide_tree.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/walk.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/group-inl.h"
#include "accel/wide/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// Rays that visit a node together; fewer go on alone.
constexpr int kTogether = 4;

/// The rays whose directions agree in their signs and largest component with the first one's.
HWY_INLINE std::uint32_t alike(const Packet& packet, std::uint32_t lanes) {
  const std::uint32_t key = packet.floats.key[static_cast<std::size_t>(std::countr_zero(lanes))];
  std::uint32_t same = 0;
  for (std::size_t i = 0; i < kLanes; ++i)
    same |= static_cast<std::uint32_t>(packet.floats.key[i] == key) << i;
  return lanes & same;
}

template <bool kAny>
void walk_lanes(const Walked& walked, Child root, std::uint32_t lanes) {
  while (lanes != 0 && !walked.packet.stopped) {
    std::uint32_t group = alike(walked.packet, lanes);
    lanes &= ~group;
    if (std::popcount(group) >= kTogether) {
      Group<kAny>(walked, group, kTogether).walk(root);
      continue;
    }
    for (; group != 0 && !walked.packet.stopped; group &= group - 1)
      Single<kAny>(walked, static_cast<std::size_t>(std::countr_zero(group))).walk(root);
  }
}

void walk_packet(const Walked& walked, Child root, std::uint32_t lanes) {
  if (walked.packet.any) {
    walk_lanes<true>(walked, root, lanes);
  } else {
    walk_lanes<false>(walked, root, lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(walk_packet);

void walk(Packet& packet, Child root, std::uint32_t lanes, SlotVisitor& slots,
          WalkTotals& totals) {
  HWY_DYNAMIC_DISPATCH(walk_packet)({packet, slots, totals}, root, lanes);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
