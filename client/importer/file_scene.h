// A scene file as its reader found it: polygons whole, numbers in double, nothing posed, turned or
// moved. Every reader gives one, and one conversion makes the imported scene from it
// (scene_from_file.h). Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/types.h"

namespace sightline::client::importer {

/// Faces with any number of corners. Face f has corners[first[f]] up to corners[first[f + 1]], in
/// order around it; one corner is a point, two are a line. Strips and fans are triangles here.
struct Polygons {
  std::vector<std::uint32_t> first{0};  ///< one more than there are faces
  std::vector<std::uint32_t> corners;   ///< indices of vertices

  std::size_t size() const { return first.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t face) const {
    return std::span(corners).subspan(first[face], first[face + 1] - first[face]);
  }
};

struct FileMesh {
  std::string name;
  std::vector<Point> vertices;
  Polygons faces;
  Skin skin;                    ///< its bones are nodes of the FileScene; no bones: no skin
  Shapes shapes;                ///< offsets of all vertices, for each shape
  std::vector<double> weights;  ///< the shapes' weights at rest
  bool is_solid = false;        ///< The format says that the mesh bounds a solid.
};

struct FileNode {
  std::string name;  ///< as in the file; not necessarily UTF-8
  std::uint32_t parent = kNone;
  Transform parent_from_local = kIdentity;
  std::vector<std::uint32_t> meshes;
};

/// Animations name nodes by their indices here. A deformation of a node without a mesh (kNone)
/// concerns all meshes of the node. Only weights need a deformation: a skin follows its bones.
struct FileScene {
  std::vector<FileMesh> meshes;
  std::vector<FileNode> nodes;  ///< parents before children, at least one
  std::vector<Animation> animations;
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: the file does not say
  std::vector<Warning> warnings;
};

/// The contents of a file, by the name that the scene file or Assimp gives it; valid as long as the
/// source. Nothing: there is no such file.
using FileSource = std::function<std::optional<std::string_view>(const std::string& name)>;

/// What a reader is given.
struct SceneFile {
  const std::string& name;
  std::string_view bytes;
  const FileSource& files;  ///< other files that it names
  const ImportOptions& options;
  const ImportProgress& progress;
};

}  // namespace sightline::client::importer
