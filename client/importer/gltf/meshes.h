// The meshes of the nodes of a glTF file. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/gltf/accessors.h"
#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

class Meshes {
 public:
  /// Adds to the meshes and warnings of `scene`. `from_gltf`: the node in the scene of each node of
  /// the file, or kNone. All arguments must outlive this object.
  Meshes(const Document& document, Buffers& buffers, Accessors& accessors,
         const std::vector<std::uint32_t>& from_gltf, FileScene& scene)
      : document_(document),
        buffers_(buffers),
        accessors_(accessors),
        from_gltf_(from_gltf),
        scene_(scene) {}

  /// The meshes for a node that has a mesh: one for each primitive. In glTF a skin and weights may
  /// belong to the node; nodes with the same mesh, skin and weights share theirs.
  const std::vector<std::uint32_t>& of(const Item& node);

  /// The number of shapes of the node's mesh.
  std::size_t shapes(const Item& node) const;

 private:
  using Use = std::tuple<std::uint64_t, std::optional<std::uint64_t>, std::vector<double>>;

  std::vector<std::uint32_t> read(const Item& mesh, const Use& use);
  FileMesh read_primitive(const Item& item, const Use& use);
  std::vector<Skin::Bone> bones(std::uint64_t skin, const std::string& by);
  void warn(const char* kind, const Item& where, const char* message);

  const Document& document_;
  Buffers& buffers_;
  Accessors& accessors_;
  const std::vector<std::uint32_t>& from_gltf_;
  FileScene& scene_;
  std::map<Use, std::vector<std::uint32_t>> known_;
};

}  // namespace sightline::client::importer::gltf
