// The faces of one node around a point, and the side on which they see it.
#include "scenegraph/query/node_faces.h"

#include <cmath>

#include "accel/geometry/triangle_mesh.h"

namespace sightline::scenegraph::query {

using accel::geometry::DoubleDouble;
using accel::geometry::FaceNormal;
using accel::geometry::Feature;
using accel::geometry::Hit;
using accel::geometry::NearestPoint;
using accel::geometry::Part;
using accel::geometry::Vec3d;

/// The face that is nearest to p, and faces that may contain its nearest point.
struct NodeFaces::Faces {
  const Vec3d& p;
  const Hit& nearest;
  std::span<const Hit> others;
};

/// The pseudonormal's product with x - p, in units that are about the distance.
struct NodeFaces::Sum {
  DoubleDouble product{};
  double weights = 0;
  bool known = true;  // Whether the errors of double-doubles are bounded

  void add(const FaceNormal& face, const Feature& feature, const NearestPoint& nearest) {
    if (feature.part == Part::kUnknown || face.area.high == 0) return;
    const DoubleDouble angle = angle_at(face, feature);
    product = product + angle * dot(face.normal, nearest.from_p);
    weights += angle.high;
  }

  /// Adds the faces that contain the nearest point. normal(primitive, FaceNormal) returns whether
  /// it knows the face.
  template <class Normal>
  void add_all(const Faces& faces, model::NodeId node, const NearestPoint& nearest,
               const Normal& normal) {
    FaceNormal face;
    known = normal(faces.nearest.primitive, face);
    if (known) add(face, nearest.feature, nearest);
    for (const Hit& hit : faces.others) {
      if (hit.node != node || hit.primitive == faces.nearest.primitive) continue;
      known = known && normal(hit.primitive, face);
      if (!known) return;
      add(face, part_at(face, nearest.seen, nearest.seen_off), nearest);
    }
  }

  /// Whether the product is more than this share of its terms.
  bool exceeds(double share) const { return std::fabs(product.high) > share * weights; }
};

void NodeFaces::enter(model::NodeId id) {
  if (id == node_) return;
  const model::Node& node = *snapshot_.find(id);
  mesh_ = node.mesh.get();
  world_from_local_ = hierarchy::world_from_local(snapshot_.hierarchy(), node);
  is_mirrored_ = accel::geometry::is_mirrored(world_from_local_.m);
  node_ = id;
}

std::array<accel::geometry::Vec3f, 3> NodeFaces::corners(std::uint32_t face) const {
  const accel::geometry::MeshView mesh = mesh_->view();
  const accel::geometry::Face& f = mesh.faces[face];
  return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

NearestPoint NodeFaces::nearest_point(const Vec3d& p, const Hit& hit) const {
  NearestPoint nearest;
  const auto vertices = corners(hit.primitive);
  if (computed_nearest(p, world_from_local_.m, vertices, hit.t, nearest)) return nearest;
  return exact_nearest(p, world_from_local_.m, vertices, hit.t);
}

NodeFaces::Sum NodeFaces::computed_sum(const Faces& faces) const {
  Sum sum;
  NearestPoint nearest;
  sum.known = computed_nearest(faces.p, world_from_local_.m, corners(faces.nearest.primitive),
                               faces.nearest.t, nearest);
  if (!sum.known) return sum;
  sum.add_all(faces, node_, nearest, [&](std::uint32_t primitive, FaceNormal& face) {
    return computed_normal(nearest.view, world_from_local_.m, corners(primitive), face);
  });
  return sum;
}

NodeFaces::Sum NodeFaces::exact_sum(const Faces& faces) const {
  Sum sum;
  const NearestPoint nearest = exact_nearest(faces.p, world_from_local_.m,
                                             corners(faces.nearest.primitive), faces.nearest.t);
  sum.add_all(faces, node_, nearest, [&](std::uint32_t primitive, FaceNormal& face) {
    face = exact_normal(nearest.view, world_from_local_.m, corners(primitive));
    return true;
  });
  return sum;
}

bool NodeFaces::is_behind(const Vec3d& p, const Hit& nearest, std::span<const Hit> others) const {
  const Faces faces{p, nearest, others};
  Sum sum = computed_sum(faces);
  if (!sum.known || !sum.exceeds(0x1p-40)) {
    sum = exact_sum(faces);
    if (!sum.exceeds(0x1p-88)) return false;
  }
  return (sum.product.high > 0) != is_mirrored_;
}

}  // namespace sightline::scenegraph::query
