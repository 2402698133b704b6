// Faces are read once for all points of a packet; of a whole mesh, vertices are read once for each
// point, which leaves few faces.
#include "accel/mesh/point_tests.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "accel/geometry/closest.h"
#include "accel/lazy/growing_leaf.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/runs.h"
#include "accel/wide/float_points.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/offer.h"

namespace sightline::accel::mesh {
namespace {

geometry::Vec3d local_point(const wide::Packet& packet, std::size_t lane) {
  const auto& at = packet.rays.origin;
  return {at[0][lane], at[1][lane], at[2][lane]};
}

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

/// Finds the nearest of the first corners of some faces, and tests its face where the nearest is
/// wanted, which limits the point.
geometry::Vec3d PointTests::nearest_of_few(std::size_t lane) {
  constexpr std::size_t kStride = 16;
  const auto corner = [&](std::size_t face) {
    return geometry::Vec3d(mesh_.vertices[mesh_.faces[face][0]]);
  };
  const geometry::Vec3d at = local_point(packet_, lane);
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh_.faces.size(); i += kStride) {
    const geometry::Vec3d way = corner(i) - at;
    const double squared = dot(way, way);
    if (squared < least) {
      least = squared;
      nearest = i;
    }
  }
  if (packet_.goal == wide::Goal::kNearest) test(lane, static_cast<std::uint32_t>(nearest));
  return corner(nearest);
}

/// The part of space that is within the point's limit, and more: a box, cut across the way to a
/// vertex.
geometry::CutBox PointTests::within_limit(std::size_t lane, const geometry::Vec3d& vertex) const {
  const geometry::Vec3d at = local_point(packet_, lane);
  const double limit = wide::local_limit(packet_, lane);
  geometry::CutBox part;
  const geometry::Vec3d way = vertex - at;
  const double longest = length(way);
  part.normal = longest > 0x1p-100 && longest < 0x1p+100 ? geometry::Vec3f(way * (1 / longest))
                                                         : geometry::Vec3f{};
  double along = 0, size = 0;
  const geometry::Vec3d normal(part.normal);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // A sum is off by less than this, a box's side by one rounding more.
    const double off = (std::fabs(at[axis]) + limit) * 0x1p-50;
    part.box.lo[axis] = geometry::round_down(at[axis] - limit - off);
    part.box.hi[axis] = geometry::round_up(at[axis] + limit + off);
    along += normal[axis] * at[axis];
    size += std::fabs(normal[axis] * at[axis]);
  }
  const double reach = limit * length(normal);
  part.most = geometry::round_up(along + reach + (size + reach) * 0x1p-49 + 0x1p-120);
  return part;
}

/// Tests all faces of a mesh that is all finite.
void PointTests::search(std::size_t lane) {
  const geometry::CutBox part = within_limit(lane, nearest_of_few(lane));
  std::vector<std::uint8_t> sides(mesh_.vertices.size());
  geometry::vertex_sides(part, mesh_.vertices, sides.data());
  const auto all = static_cast<std::uint32_t>(mesh_.faces.size());
  std::array<std::uint32_t, lazy::kSearchStep> ids;
  for (std::uint32_t i = 0; i < all && packet_.left(1u << lane) != 0; i += ids.size()) {
    if (cells_.is_cancelled()) packet_.stopped = true;
    const std::uint32_t end = std::min<std::uint32_t>(i + ids.size(), all);
    const std::size_t left =
        geometry::faces_on_no_side(mesh_.faces, i, end, sides.data(), ids.data());
    leaf({ids.data(), left}, 1u << lane);
  }
}

void PointTests::everything(const kdtree::DeferredCell&, std::uint32_t lanes) {
  if (!mesh_.all_finite) return faces(0, mesh_.faces.size(), lanes);
  for (lanes = packet_.left(lanes); lanes != 0; lanes = packet_.left(lanes & (lanes - 1)))
    search(static_cast<std::size_t>(std::countr_zero(lanes)));
}

}  // namespace sightline::accel::mesh
