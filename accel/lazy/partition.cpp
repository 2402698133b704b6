// Sifting, counting for the children and clipping in one go.
#include "accel/lazy/partition.h"

#include "accel/grow/clip_straddlers.h"
#include "accel/kdtree/sift.h"

namespace sightline::accel::lazy {

PartitionResult sift_spans(const PartitionInput& input,
                           std::span<const std::span<const kdtree::Reference>> spans,
                           std::size_t size, kdtree::BuildCounters& counters) {
  PartitionResult sides;
  const std::span<kdtree::Reference> buffer = scratch(2 * size);
  const std::span<kdtree::Reference> left = buffer.first(size), right = buffer.subspan(size);
  split::ChildScans scans;
  if (input.scans) {
    scans.left_planes = input.rule->child_planes(input.halves.left);
    scans.right_planes = input.rule->child_planes(input.halves.right);
  }
  kdtree::PartitionCounts n;
  for (const std::span<const kdtree::Reference> part : spans) {
    kdtree::Reference* const to_left = left.data() + n.left;
    kdtree::Reference* const to_right = right.data() + n.right;
    const kdtree::PartitionCounts more =
        input.scans ? sift_and_count(part, input.cut.plane, to_left, to_right, scans)
                    : kdtree::sift(part, input.cut, to_left, to_right);
    n.left += more.left;
    n.right += more.right;
  }
  counters.touches += size;
  const kdtree::Plane& plane = input.cut.plane;
  if (input.openable) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const kdtree::Reference& ref : left.first(n.left))
      sides.straddling.openable += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  sides.straddling.all = n.left + n.right - size;
  const std::size_t seen = input.whole ? size : 0;  // one slice says nothing of all
  if (input.clipped && input.rule->clips(sides.straddling.all, seen)) {
    scans = {};
    n.left = grow::clip_straddlers(*input.clipped, left.first(n.left), plane, input.halves.left);
    n.right =
        grow::clip_straddlers(*input.clipped, right.first(n.right), plane, input.halves.right);
  }
  sides.left = kdtree::ReferenceList(left.first(n.left));
  sides.right = kdtree::ReferenceList(right.first(n.right));
  sides.left_scan = scans.left;
  sides.right_scan = scans.right;
  return sides;
}

std::span<kdtree::Reference> scratch(std::size_t size) {
  thread_local kdtree::ReferenceList buffer;
  if (buffer.size() < size) {
    buffer = {};
    buffer = kdtree::ReferenceList(size);
  }
  return buffer.all();
}

}  // namespace sightline::accel::lazy
