// Meshes whose triangles lie flat on each other, coincide or crowd in one place: no cut separates
// them. The memory of a tree over them must stay as small as over any other mesh.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/support/scenes.h"

namespace sightline::tests {

struct ClusteredMesh {
  std::string_view name;
  std::string_view what;
  TestMesh (*make)(std::uint32_t triangles, std::uint64_t seed);  ///< Of exactly that many faces.
};

const std::vector<ClusteredMesh>& clustered_meshes();
/// Null if there is no mesh of that name.
const ClusteredMesh* find_clustered_mesh(std::string_view name);

}  // namespace sightline::tests
