// Boxes whose sides are known by formula.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "client/importer/imported_scene.h"

namespace sightline::tests {

struct Box {
  std::array<float, 3> low, high;

  /// Of a point: the exact distance from the surface, rounded once if the coordinates have few
  /// bits; negative inside.
  double signed_distance(const std::array<double, 3>& point) const;
};

inline constexpr std::size_t kFacesOfBox = 12;

/// The first `faces` faces of the box, with their fronts outside. The last two are its top, where z
/// is highest.
client::importer::ImportedMesh mesh_of(const Box& box, std::size_t faces = kFacesOfBox);

/// A scene with a node for each mesh, in this order: nodes 1, 2 and so on.
client::importer::ImportedScene scene_of(std::vector<client::importer::ImportedMesh> meshes);

/// The meshes as a file, each an object.
std::string obj_of(const std::vector<client::importer::ImportedMesh>& meshes);

}  // namespace sightline::tests
