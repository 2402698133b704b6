// Sifting, counting for the children and clipping in one go.
#include "accel/lazy/sieve.h"

#include "accel/grow/clip_straddlers.h"
#include "accel/kdtree/sift.h"

namespace sightline::accel::lazy {

Sides sift_spans(const Sieve& sieve, std::span<const std::span<const kdtree::BoxRef>> spans,
                 std::size_t size, kdtree::BuildCounters& counters) {
  Sides sides;
  const std::span<kdtree::BoxRef> room = scratch(2 * size);
  const std::span<kdtree::BoxRef> left = room.first(size), right = room.subspan(size);
  split::FirstScans scans;
  if (sieve.scans) {
    scans.left_planes = sieve.rule->first_planes(sieve.halves.left);
    scans.right_planes = sieve.rule->first_planes(sieve.halves.right);
  }
  kdtree::Sifted n;
  for (const std::span<const kdtree::BoxRef> part : spans) {
    kdtree::BoxRef* const to_left = left.data() + n.left;
    kdtree::BoxRef* const to_right = right.data() + n.right;
    const kdtree::Sifted more = sieve.scans
                                    ? sift_and_scan(part, sieve.cut.plane, to_left, to_right, scans)
                                    : kdtree::sift(part, sieve.cut, to_left, to_right);
    n.left += more.left;
    n.right += more.right;
  }
  counters.touches += size;
  const kdtree::Plane& plane = sieve.cut.plane;
  if (sieve.openable) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const kdtree::BoxRef& ref : left.first(n.left))
      sides.straddling.openable += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  sides.straddling.all = n.left + n.right - size;
  const std::size_t seen = sieve.whole ? size : 0;  // one slice says nothing of all
  if (sieve.clipped && sieve.rule->clips(sides.straddling.all, seen)) {
    scans = {};
    n.left = grow::clip_straddlers(*sieve.clipped, left.first(n.left), plane, sieve.halves.left);
    n.right =
        grow::clip_straddlers(*sieve.clipped, right.first(n.right), plane, sieve.halves.right);
  }
  sides.left = kdtree::BoxList(left.first(n.left));
  sides.right = kdtree::BoxList(right.first(n.right));
  sides.left_scan = scans.left;
  sides.right_scan = scans.right;
  return sides;
}

std::span<kdtree::BoxRef> scratch(std::size_t size) {
  thread_local kdtree::BoxList room;
  if (room.size() < size) {
    room = {};
    room = kdtree::BoxList(size);
  }
  return room.all();
}

}  // namespace sightline::accel::lazy
