// Checking a mesh's arrays.
#include "scenegraph/model/mesh.h"

#include <algorithm>

namespace sightline::scenegraph {
namespace {

Error bad_index(const accel::Face& face, std::size_t i, std::size_t vertices) {
  const std::uint32_t worst = *std::max_element(face.begin(), face.end());
  return {Code::kInvalidArgument,
          "face " + std::to_string(i) + " has vertex index " + std::to_string(worst) +
              ", but the mesh has " + std::to_string(vertices) + " vertices",
          "INDEX_OUT_OF_RANGE"};
}

/// A tree that may last for one frame begins with single triangles up to here; beyond, sparse rays
/// would pay too much for the list of all.
constexpr std::uint64_t kSoupUpTo = std::uint64_t{1} << 18;

}  // namespace

Result<std::shared_ptr<const Mesh>> Mesh::make(std::vector<accel::Vec3f> vertices,
                                               std::vector<accel::Face> faces,
                                               const accel::AnyBuilder& builder,
                                               accel::References references) {
  if (faces.size() > kMaxFacesPerMesh) {
    return Error{Code::kResourceExhausted,
                 "the mesh has " + std::to_string(faces.size()) + " faces, the limit is " +
                     std::to_string(kMaxFacesPerMesh),
                 "MESH_TOO_LARGE"};
  }
  auto arrays = std::make_shared<const Arrays>(
      std::move(vertices), std::make_shared<const std::vector<accel::Face>>(std::move(faces)));
  const accel::MeshView view{arrays->vertices, *arrays->faces};
  const accel::MeshSurvey survey = accel::survey_mesh(view);
  if (const std::size_t bad = survey.first_bad_face; bad < view.faces.size())
    return bad_index(view.faces[bad], bad, view.vertices.size());
  return std::shared_ptr<const Mesh>(new Mesh(std::move(arrays), survey, builder, references));
}

Mesh::Mesh(std::shared_ptr<const Arrays> arrays, const accel::MeshSurvey& survey,
           const accel::AnyBuilder& builder, accel::References references)
    : arrays_(std::move(arrays)),
      bounds_(survey.bounds),
      triangles_(survey.triangles),
      nonfinite_(survey.triangles - survey.finite_triangles),
      builder_(builder),
      references_(references),
      tree_(std::make_unique<accel::MeshTree>(view(), survey, builder, references, arrays_)) {}

Result<std::shared_ptr<const Mesh>> Mesh::deformed(std::vector<accel::Vec3f> vertices) const {
  if (vertices.size() != arrays_->vertices.size()) {
    return Error{Code::kInvalidArgument,
                 std::to_string(vertices.size()) + " vertices, but the mesh has " +
                     std::to_string(arrays_->vertices.size()),
                 "COUNT_MISMATCH"};
  }
  auto arrays = std::make_shared<const Arrays>(std::move(vertices), arrays_->faces);
  const accel::MeshSurvey survey = accel::survey_mesh({arrays->vertices, *arrays->faces});
  const bool by_default = builder_ == accel::AnyBuilder(accel::default_builder());
  return std::shared_ptr<const Mesh>(new Mesh(
      std::move(arrays), survey, by_default ? accel::AnyBuilder(accel::frame_builder()) : builder_,
      by_default && triangles_ <= kSoupUpTo ? accel::References::kSoup : references_));
}

std::uint64_t Mesh::bytes() const {
  return arrays_->vertices.size() * sizeof(accel::Vec3f) +
         arrays_->faces->size() * sizeof(accel::Face);
}

}  // namespace sightline::scenegraph
