// Meshes at their places in a scene, whose triangles lie in the blocks of one tree.
#pragma once

#include <array>
#include <cstdint>

#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::wide {

struct GivenRays;

/// An affine transform: a 3x4 matrix by rows.
using Matrix = std::array<double, 12>;

/// A mesh at its place. What it refers to outlives the tree.
struct PlacedMesh {
  geometry::MeshView mesh;
  const Matrix *local_from_scene = nullptr, *scene_from_local = nullptr;
  std::uint64_t node = 0;
  std::uint32_t instance = 0;  ///< The caller's number for the node.
  std::uint32_t first = 0;     ///< The number of its first face among the faces of all meshes.
};

/// Which rays see a mesh, for packets that do not see all.
struct Visibility {
  /// The rays of `lanes` that see this mesh.
  std::uint32_t (*seeing)(const void* asked, const PlacedMesh& mesh, std::uint32_t lanes);
  const void* asked;
};

/// What a packet needs to know in a flat tree, whose blocks have the numbers of faces among those
/// of all meshes.
struct PlacedMeshes {
  const PlacedMesh* all = nullptr;         ///< Null in other trees.
  const std::uint32_t* mesh_of = nullptr;  ///< The index of each face's mesh.
  const GivenRays* given = nullptr;        ///< The rays before any transform.
  const Visibility* visible = nullptr;     ///< Null: all rays see all meshes.
  std::uint32_t first_instance = 0;        ///< Added to PlacedMesh::instance.

  /// The mesh of a face.
  const PlacedMesh& of(std::uint32_t id) const { return all[mesh_of[id]]; }
};

}  // namespace sightline::accel::wide
