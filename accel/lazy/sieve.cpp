// Sifting, counting for the children and clipping in one go.
#include "accel/lazy/sieve.h"

#include <optional>

namespace sightline::accel::lazy {

Sides sift_spans(const Sieve& sieve, std::span<const std::span<const kdtree::BoxRef>> spans,
                 std::size_t size, kdtree::BuildCounters& counters) {
  Sides sides;
  const std::span<kdtree::BoxRef> room = scratch(2 * size);
  const std::span<kdtree::BoxRef> left = room.first(size), right = room.subspan(size);
  std::optional<split::FirstScans> scans = sieve.cut.first_scans();
  kdtree::Sifted n;
  for (const std::span<const kdtree::BoxRef> part : spans) {
    const kdtree::Sifted more =
        sieve.cut.sift(part, left.data() + n.left, right.data() + n.right, scans);
    n.left += more.left;
    n.right += more.right;
  }
  counters.touches += size;
  if (sieve.openable) {
    const kdtree::Plane& plane = sieve.cut.cut().plane;
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const kdtree::BoxRef& ref : left.first(n.left))
      sides.straddling.openable += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  sides.straddling.all = n.left + n.right - size;
  const std::size_t seen = sieve.whole ? size : 0;  // one slice does not tell about the list
  if (sieve.cut.clips(sides.straddling.all, seen)) {
    n = sieve.cut.clip(left.first(n.left), right.first(n.right));
    scans.reset();
  }
  sides.left = kdtree::BoxList(left.first(n.left));
  sides.right = kdtree::BoxList(right.first(n.right));
  if (scans) {
    sides.left_scan = scans->left;
    sides.right_scan = scans->right;
  }
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
