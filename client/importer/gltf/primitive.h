// One primitive of a glTF mesh. Internal to the importer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/importer/animation.h"
#include "client/importer/file_scene.h"
#include "client/importer/gltf/accessors.h"
#include "client/importer/gltf/document.h"
#include "client/importer/gltf/draco.h"
#include "client/importer/gltf/faces.h"

namespace sightline::client::importer::gltf {

class Primitive {
 public:
  /// Decompresses it, if it is compressed. All arguments must outlive this object.
  Primitive(const Item& item, const Document& document, Buffers& buffers, Accessors& accessors);

  /// Whether there are positions: without them there is nothing to read.
  bool has_positions() const { return find("POSITION").has_value(); }
  Mode mode() const { return mode_; }
  std::vector<Point> vertices();
  /// Refuses an index without a vertex, and the greatest one of the type, which the format
  /// reserves.
  std::vector<std::uint32_t> indices(std::size_t vertices);
  Shapes shapes(std::size_t vertices);
  /// Whether vertices say which joints they follow.
  bool has_joints() const { return find("JOINTS_0").has_value(); }
  /// Scales the weights of each vertex so that they add up to 1. Refuses a weight that is negative
  /// or not finite, and a joint that is none of `bones`.
  Skin skin(std::vector<Skin::Bone> bones, std::size_t vertices);

 private:
  std::optional<std::uint64_t> find(const std::string& attribute) const;
  void decompress(const Item& extension, const Document& document, Buffers& buffers);
  std::vector<std::array<double, 4>> influences(const std::string& attribute, std::size_t vertices);

  template <std::size_t kWidth>
  std::vector<std::array<double, kWidth>> rows(const std::string& attribute);

  const Item& item_;
  Accessors& accessors_;
  Mode mode_;
  std::vector<std::pair<std::string, std::uint64_t>> attributes_;
  std::optional<DracoMesh> draco_;
};

}  // namespace sightline::client::importer::gltf
