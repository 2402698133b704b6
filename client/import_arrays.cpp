// A scene of one mesh, from the arrays of a program.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "client/client.h"

namespace sightline::client {
namespace {

// The rows of (n, 3) numbers. Copies them, because numbers are no arrays of three to the compiler.
template <class Row, class Number>
Result<std::vector<Row>> rows_of(const char* name, std::span<const Number> numbers) {
  if (numbers.size() % 3 != 0) {
    return Error{Code::kInvalidArgument,
                 fmt::format("{} have {} numbers: not 3 each", name, numbers.size()),
                 "NUMBER_COUNT"};
  }
  std::vector<Row> rows(numbers.size() / 3);
  for (std::size_t i = 0; i < rows.size(); ++i) std::copy_n(&numbers[3 * i], 3, rows[i].begin());
  return rows;
}

Status check_faces(std::size_t vertices, std::span<const Face> faces) {
  if (faces.empty())
    return Error{Code::kInvalidArgument, "a mesh without faces has nothing to hit", "NO_FACES"};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::uint32_t highest = *std::max_element(faces[i].begin(), faces[i].end());
    if (highest < vertices || faces[i] == Face{kNoVertex, kNoVertex, kNoVertex}) continue;
    return Error{
        Code::kInvalidArgument,
        fmt::format("face {} has vertex {}, but there are {} vertices", i, highest, vertices),
        "NO_SUCH_VERTEX"};
  }
  return {};
}

}  // namespace

Result<SceneInfo> Client::import_arrays(const std::string& scene, std::span<const Vertex> vertices,
                                        std::span<const Face> faces,
                                        const PutSceneOptions& options) const {
  if (const Status checked = check_faces(vertices.size(), faces); !checked) return checked.error();
  if (!options.replace) {
    const auto there = get_scene(scene, options.stop);
    if (there)
      return Error{Code::kAlreadyExists, fmt::format("scene {} exists", scene), "SCENE_EXISTS"};
    if (there.error().code != Code::kNotFound) return there.error();
  }
  const MeshBlob mesh(vertices, faces);
  const std::string digest = mesh.digest();
  const auto missing = missing_meshes({&digest, 1});
  if (!missing) return missing.error();
  if (!missing->empty()) {
    if (const Status sent = upload_mesh(mesh, digest, {}, options.stop); !sent) return sent.error();
  }
  const PutNode node{.node = -1, .name = "mesh", .mesh_digest = digest};
  return put_scene(scene, {&node, 1}, options);
}

Result<SceneInfo> Client::import_arrays(const std::string& scene, std::span<const float> vertices,
                                        std::span<const std::uint32_t> faces,
                                        const PutSceneOptions& options) const {
  const auto vertex_rows = rows_of<Vertex>("vertices", vertices);
  if (!vertex_rows) return vertex_rows.error();
  const auto face_rows = rows_of<Face>("faces", faces);
  if (!face_rows) return face_rows.error();
  return import_arrays(scene, *vertex_rows, *face_rows, options);
}

}  // namespace sightline::client
