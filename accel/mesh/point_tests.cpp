// Faces are read once for all points of a packet.
#include "accel/mesh/point_tests.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "accel/geometry/closest.h"
#include "accel/lazy/growing_leaf.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/runs.h"
#include "accel/wide/float_points.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/offer.h"

namespace sightline::accel::mesh {
namespace {

/// Whether a box in the mesh's frame is certainly too far from a point.
bool is_beyond(const wide::Packet& packet, std::size_t lane, const geometry::Aabb& box) {
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = packet.rays.origin[axis][lane];
    const double gap = std::max(
        {static_cast<double>(box.lo[axis]) - at, at - static_cast<double>(box.hi[axis]), 0.0});
    squared += gap * gap;
  }
  const double limit = wide::local_limit(packet, lane);
  return squared * (1 - 0x1p-48) > limit * limit;
}

}  // namespace

void PointTests::test(std::size_t lane, std::uint32_t face) {
  ++walked_.tests;
  ++packet_.work[lane];
  const geometry::Face& f = mesh_.faces[face];
  const double distance =
      geometry::distance(wide::scene_point(packet_, lane), *packet_.scene_from_local,
                         mesh_.vertices[f[0]], mesh_.vertices[f[1]], mesh_.vertices[f[2]]);
  if (offer(packet_, lane, distance, {.id = face})) wide::tighten(packet_, lane);
}

void PointTests::leaf(std::span<const std::uint32_t> ids, std::uint32_t lanes) {
  for (const std::uint32_t face : ids) faces(face, face + std::size_t{1}, lanes);
}

void PointTests::faces(std::size_t begin, std::size_t end, std::uint32_t lanes) {
  for (std::size_t i = begin; i < end; ++i) {
    if ((i - begin) % lazy::kSearchStep == lazy::kSearchStep - 1 && cells_.is_cancelled())
      packet_.stopped = true;
    lanes = packet_.left(lanes);
    if (lanes == 0) return;
    const std::optional<geometry::Aabb> box = face_bounds(mesh_, i);
    if (!box) continue;
    for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      if (!is_beyond(packet_, lane, *box)) test(lane, static_cast<std::uint32_t>(i));
    }
  }
}

void PointTests::references(std::span<const kdtree::Reference> refs, std::uint32_t lanes) {
  for (const kdtree::Reference& ref : refs) {
    std::uint32_t near = 0;
    for (std::uint32_t left = packet_.left(lanes); left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      if (!is_beyond(packet_, lane, ref.bounds())) near |= 1u << lane;
    }
    if (near == 0) continue;
    const FaceRange run =
        ref.openable() ? faces_of_run(mesh_, ref) : FaceRange{ref.id, ref.id + std::size_t{1}};
    faces(run.begin, run.end, near);
  }
}

void PointTests::everything(const kdtree::DeferredCell&, std::uint32_t lanes) {
  faces(0, mesh_.faces.size(), lanes);
}

}  // namespace sightline::accel::mesh
