// Whether meshes are closed. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

struct OpenEdges {
  std::uint64_t count = 0;
  std::size_t mesh = 0;  ///< the mesh of the first of them,
  std::size_t face = 0;  ///< and its face
};

/// Counts the edges of these meshes together that only one triangle has. Vertices at the same
/// position count as one; triangles with two of them, or with a vertex that is not finite, do not
/// count.
OpenEdges open_edges(std::span<const ImportedMesh* const> meshes);

/// How many of the lines through these meshes cross an odd number of triangles; a closed surface
/// has none. Lines near an edge are not used. The lines are always the same.
struct OddLines {
  std::uint64_t odd = 0;
  std::uint64_t lines = 0;
};
OddLines odd_lines(std::span<const ImportedMesh* const> meshes);

}  // namespace sightline::client::importer
