// Checking a mesh's arrays.
#include "scenegraph/model/mesh.h"

#include <algorithm>

namespace sightline::scenegraph::model {
namespace {

Error bad_index(const accel::geometry::Face& face, std::size_t i, std::size_t vertices) {
  const std::uint32_t worst = *std::max_element(face.begin(), face.end());
  return {Code::kInvalidArgument,
          "face " + std::to_string(i) + " has vertex index " + std::to_string(worst) +
              ", but the mesh has " + std::to_string(vertices) + " vertices",
          "INDEX_OUT_OF_RANGE"};
}

}  // namespace

Result<std::shared_ptr<const Mesh>> Mesh::make(std::vector<accel::geometry::Vec3f> vertices,
                                               std::vector<accel::geometry::Face> faces,
                                               const accel::mesh::TreeBuilder& builder,
                                               accel::mesh::References references) {
  if (faces.size() > kMaxFacesPerMesh) {
    return Error{Code::kResourceExhausted,
                 "the mesh has " + std::to_string(faces.size()) + " faces, the limit is " +
                     std::to_string(kMaxFacesPerMesh),
                 "MESH_TOO_LARGE"};
  }
  auto arrays = std::make_shared<const Arrays>(
      std::move(vertices),
      std::make_shared<const std::vector<accel::geometry::Face>>(std::move(faces)));
  const accel::geometry::MeshView view{arrays->vertices, *arrays->faces};
  const accel::mesh::MeshStats survey = accel::mesh::compute_mesh_stats(view);
  if (const std::size_t bad = survey.first_bad_face; bad < view.faces.size())
    return bad_index(view.faces[bad], bad, view.vertices.size());
  return std::shared_ptr<const Mesh>(new Mesh(std::move(arrays), survey, builder, references));
}

Mesh::Mesh(std::shared_ptr<const Arrays> arrays, const accel::mesh::MeshStats& survey,
           const accel::mesh::TreeBuilder& builder, accel::mesh::References references)
    : arrays_(std::move(arrays)),
      bounds_(survey.bounds),
      triangles_(survey.triangles),
      nonfinite_(survey.triangles - survey.finite_triangles),
      builder_(builder),
      references_(references),
      tree_(std::make_unique<accel::mesh::MeshTree>(view(), survey, builder, references, arrays_)) {
}

Result<std::shared_ptr<const Mesh>> Mesh::deformed(
    std::vector<accel::geometry::Vec3f> vertices) const {
  if (vertices.size() != arrays_->vertices.size()) {
    return Error{Code::kInvalidArgument,
                 std::to_string(vertices.size()) + " vertices, but the mesh has " +
                     std::to_string(arrays_->vertices.size()),
                 "COUNT_MISMATCH"};
  }
  auto arrays = std::make_shared<const Arrays>(std::move(vertices), arrays_->faces);
  const accel::mesh::MeshStats survey =
      accel::mesh::compute_mesh_stats({arrays->vertices, *arrays->faces});
  return std::shared_ptr<const Mesh>(new Mesh(std::move(arrays), survey, builder_, references_));
}

std::uint64_t Mesh::bytes() const {
  return arrays_->vertices.size() * sizeof(accel::geometry::Vec3f) +
         arrays_->faces->size() * sizeof(accel::geometry::Face);
}

}  // namespace sightline::scenegraph::model
