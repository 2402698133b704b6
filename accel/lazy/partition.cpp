// Sifting, counting for the children and clipping in one go.
#include "accel/lazy/partition.h"

#include <optional>

namespace sightline::accel::lazy {

PartitionResult sift_spans(const PartitionInput& input,
                           std::span<const std::span<const kdtree::Reference>> spans,
                           std::size_t size, kdtree::BuildCounters& counters) {
  PartitionResult sides;
  const std::span<kdtree::Reference> buffer = scratch(2 * size);
  const std::span<kdtree::Reference> left = buffer.first(size), right = buffer.subspan(size);
  std::optional<split::ChildScans> scans = input.cut.first_scans();
  kdtree::PartitionCounts n;
  for (const std::span<const kdtree::Reference> part : spans) {
    const kdtree::PartitionCounts more =
        input.cut.sift(part, left.data() + n.left, right.data() + n.right, scans);
    n.left += more.left;
    n.right += more.right;
  }
  counters.touches += size;
  if (input.openable) {
    const kdtree::Plane& plane = input.cut.cut().plane;
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const kdtree::Reference& ref : left.first(n.left))
      sides.straddling.openable += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  sides.straddling.all = n.left + n.right - size;
  if (input.cut.clips(sides.straddling.all, size)) {
    n = input.cut.clip(left.first(n.left), right.first(n.right));
    scans.reset();
  }
  sides.left = kdtree::ReferenceList(left.first(n.left));
  sides.right = kdtree::ReferenceList(right.first(n.right));
  if (scans) {
    sides.left_scan = scans->left;
    sides.right_scan = scans->right;
  }
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
