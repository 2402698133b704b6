// Checking a mesh's arrays.
#include "scenegraph/mesh.h"

#include <algorithm>
#include <optional>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::scenegraph {
namespace {

constexpr std::size_t kFacesPerTask = 65536;

bool holds_triangle(const accel::Face& f) {
  return !(f[0] == accel::kNoVertex && f[1] == accel::kNoVertex && f[2] == accel::kNoVertex);
}

struct Survey {
  std::uint64_t triangles = 0;
  std::size_t first_bad = ~std::size_t{0};
};

Survey survey(const std::vector<accel::Face>& faces, std::size_t vertices) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, faces.size(), kFacesPerTask), Survey{},
      [&](const auto& range, Survey s) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const accel::Face& f = faces[i];
          if (!holds_triangle(f)) continue;
          ++s.triangles;
          if (f[0] >= vertices || f[1] >= vertices || f[2] >= vertices)
            s.first_bad = std::min(s.first_bad, i);
        }
        return s;
      },
      [](const Survey& a, const Survey& b) {
        return Survey{a.triangles + b.triangles, std::min(a.first_bad, b.first_bad)};
      });
}

Error bad_index(const accel::Face& face, std::size_t i, std::size_t vertices) {
  const std::uint32_t worst = *std::max_element(face.begin(), face.end());
  return {Code::kInvalidArgument,
          "face " + std::to_string(i) + " has vertex index " + std::to_string(worst) +
              ", but the mesh has " + std::to_string(vertices) + " vertices",
          "INDEX_OUT_OF_RANGE"};
}

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
  const Survey found = survey(faces, vertices.size());
  if (found.first_bad < faces.size())
    return bad_index(faces[found.first_bad], found.first_bad, vertices.size());

  std::shared_ptr<Mesh> mesh(new Mesh);
  mesh->vertices_ = std::move(vertices);
  mesh->faces_ = std::move(faces);
  const accel::MeshBounds bounds = accel::mesh_bounds(mesh->view());
  mesh->bounds_ = bounds.box;
  mesh->triangles_ = found.triangles;
  mesh->nonfinite_ = found.triangles - bounds.count;
  mesh->tree_ = std::make_unique<accel::MeshTree>(mesh->view(), bounds.box, bounds.count, builder,
                                                  references);
  return std::shared_ptr<const Mesh>(std::move(mesh));
}

std::uint64_t Mesh::bytes() const {
  return vertices_.size() * sizeof(accel::Vec3f) + faces_.size() * sizeof(accel::Face);
}

}  // namespace sightline::scenegraph
