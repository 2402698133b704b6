// Boxes whose sides are known by formula.
#include "tests/client/support/boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace sightline::tests {

double Box::signed_distance(const std::array<double, 3>& point) const {
  double square = 0, inside = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const double beyond =
        std::max(static_cast<double>(low[k]) - point[k], point[k] - static_cast<double>(high[k]));
    inside = std::max(inside, beyond);
    if (beyond > 0) square += beyond * beyond;
  }
  return inside < 0 ? inside : std::sqrt(square);
}

client::importer::ImportedMesh mesh_of(const Box& box, std::size_t faces) {
  // Bit k of a corner's number tells whether it is at the high end of axis k.
  constexpr std::array<std::array<std::uint32_t, 3>, kFacesOfBox> kFaces{{{0, 2, 3},
                                                                          {0, 3, 1},
                                                                          {0, 1, 5},
                                                                          {0, 5, 4},
                                                                          {2, 6, 7},
                                                                          {2, 7, 3},
                                                                          {0, 4, 6},
                                                                          {0, 6, 2},
                                                                          {1, 3, 7},
                                                                          {1, 7, 5},
                                                                          {4, 5, 7},
                                                                          {4, 7, 6}}};
  client::importer::ImportedMesh mesh;
  mesh.name = "box";
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const auto at = [&](std::size_t k) {
      return (corner >> k & 1U) != 0 ? box.high[k] : box.low[k];
    };
    mesh.vertices.push_back({at(0), at(1), at(2)});
  }
  for (std::size_t i = 0; i < faces; ++i)
    mesh.faces.push_back({kFaces[i][0], kFaces[i][1], kFaces[i][2]});
  mesh.triangles = faces;
  return mesh;
}

client::importer::ImportedScene scene_of(std::vector<client::importer::ImportedMesh> meshes) {
  client::importer::ImportedScene scene;
  for (std::uint32_t i = 0; i < meshes.size(); ++i)
    scene.nodes.push_back({.name = meshes[i].name, .mesh = i});
  scene.meshes = std::move(meshes);
  return scene;
}

std::string obj_of(const std::vector<client::importer::ImportedMesh>& meshes) {
  std::string text;
  std::size_t before = 1;  // the format counts from 1
  for (const auto& mesh : meshes) {
    text += "o " + mesh.name + "\n";
    for (const auto& vertex : mesh.vertices)
      text += fmt::format("v {} {} {}\n", vertex[0], vertex[1], vertex[2]);
    for (const auto& face : mesh.faces)
      text += fmt::format("f {} {} {}\n", face[0] + before, face[1] + before, face[2] + before);
    before += mesh.vertices.size();
  }
  return text;
}

}  // namespace sightline::tests
