// A scene file as its reader found it: polygons whole, numbers in double, nothing posed, turned or
// moved. Every reader gives one, and one conversion makes the imported scene from it. Internal to
// the importer.
#pragma once

#include <cstdint>
#include <string>
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
};

struct FileMesh {
  std::string name;
  std::vector<Point> vertices;
  Polygons faces;
  Skin skin;                    ///< its bones are nodes of the FileScene; no bones: no skin
  Shapes shapes;                ///< offsets of all vertices, for each shape
  std::vector<double> weights;  ///< of the shapes, at rest
  bool is_solid = false;        ///< The format says that the mesh bounds a solid.
};

struct FileNode {
  std::string name;  ///< as in the file; not necessarily UTF-8
  std::uint32_t parent = kNone;
  Transform parent_from_local = kIdentity;
  std::vector<std::uint32_t> meshes;
};

/// Animations name nodes by their indices here. A deformation of a node without a mesh (kNone)
/// concerns all meshes of the node.
struct FileScene {
  std::vector<FileMesh> meshes;
  std::vector<FileNode> nodes;  ///< parents before children
  std::vector<Animation> animations;
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: the file does not say
  std::vector<std::string> warnings;
};

}  // namespace sightline::client::importer
