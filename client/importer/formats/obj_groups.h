// The objects of an OBJ file, and their parts. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "client/importer/file_scene.h"

namespace sightline::client::importer::formats {

/// Faces go to the part that was opened last. Objects and parts are those of Assimp, so that nodes,
/// meshes and the numbers of faces are those of earlier versions of this program.
class ObjGroups {
 public:
  /// `o`: an object of this name is continued.
  void open_object(std::string_view name);
  /// `g`: a name that differs from the last one begins an object.
  void open_group(std::string_view name);
  /// `usemtl`: begins a part, unless the last one has no faces, or had no material yet.
  void use_material(std::string_view name);

  /// `corners` are indices of the file's vertices.
  void add_face(std::span<const std::uint32_t> corners);
  std::size_t corners() const { return corner_count_; }  ///< corners of all faces

  /// A node for each object, and a mesh for each part with faces. A file without faces is a mesh of
  /// points.
  FileScene scene(const std::string& name, const std::vector<Point>& vertices) &&;

 private:
  struct Part {
    std::string name;
    std::optional<std::string> material;
    Polygons faces;
  };
  struct Object {
    std::string name;
    std::vector<std::size_t> parts;
  };

  void begin_object(std::string_view name);
  void begin_part(std::string_view name);

  std::vector<Object> objects_;
  std::vector<Part> parts_;
  std::unordered_map<std::string, std::size_t> object_by_name_;
  std::size_t object_ = 0, part_ = 0;  // the open ones, if there are any
  std::string group_;
  std::optional<std::string> material_;
  std::size_t corner_count_ = 0;
};

}  // namespace sightline::client::importer::formats
