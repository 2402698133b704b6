// The nodes of a glTF file's scene. Internal to the importer.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/importer/animation.h"
#include "client/importer/file_scene.h"
#include "client/importer/gltf/accessors.h"
#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

/// The limit on instances: a few bytes may stand for many.
inline constexpr std::uint64_t kMostNodes = std::uint64_t{1} << 20U;

struct Nodes {
  std::vector<FileNode> nodes;           ///< depth first, children in order; without meshes
  std::vector<std::uint32_t> from_gltf;  ///< the node of each node of the file, or kNone

  /// A node of the file that has a mesh, and the nodes that have it in the scene: itself or its
  /// instances.
  struct MeshNodes {
    std::uint32_t gltf = 0;
    std::uint32_t first = 0, count = 1;
  };
  std::vector<MeshNodes> mesh_nodes;  ///< the nodes that can be seen
};

/// The rows of a matrix that is stored by columns. Refuses one whose last row is not 0 0 0 1;
/// `last_row` begins the message.
Transform affine_of(const std::array<double, 16>& columns, const std::string& last_row);

/// A node's own transform. Refuses a matrix that is not affine.
struct LocalTransform {
  bool has_matrix = false;
  Transform matrix = kIdentity;  ///< parent from local
  /// What it is made of, without a matrix.
  Point translation{0, 0, 0};
  Quaternion rotation{1, 0, 0, 0};
  Point scale{1, 1, 1};
};
LocalTransform local_transform(const Item& node);

/// The quaternion of length 1 with this direction; x y z w, as in the file. Zeros give no rotation.
Quaternion rotation_of(const std::array<double, 4>& xyzw);

/// Reads the scene that the file names, else its first one, and all nodes if it has no scenes.
/// Several roots get a root node ROOT above them. A node with EXT_mesh_gpu_instancing gets a child
/// for each instance, NAME#0, NAME#1 and so on. Refuses nodes with two parents and too many
/// instances. Adds to `warnings`.
Nodes read_nodes(const Document& document, Accessors& accessors, std::vector<Warning>& warnings);

}  // namespace sightline::client::importer::gltf
