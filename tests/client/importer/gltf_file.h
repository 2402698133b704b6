// A small glTF file, written number by number.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::tests {

class GltfFile {
 public:
  GltfFile();

  /// Adds an accessor of `rows.size() / width` rows and returns its number; `type` is SCALAR, VEC3,
  /// VEC4 or MAT4.
  int add(const std::vector<float>& rows, const std::string& type);
  /// The same of unsigned shorts.
  int add_shorts(const std::vector<std::uint16_t>& rows, const std::string& type);
  /// Adds a channel that moves `path` (translation, rotation, scale, weights) of a node.
  void animate(int node, const std::string& path, const std::vector<float>& seconds,
               const std::vector<float>& values);

  std::string text() const;

  nlohmann::json json;  ///< All but buffers, bufferViews and accessors is the caller's.

 private:
  int add_bytes(std::string_view bytes, int component, std::size_t rows, const std::string& type);

  std::string bytes_;
};

/// A node 1 that carries a triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0), under a root 0.
GltfFile triangle_under_root();

/// A strip of four triangles in x from -0.5 to 0.5, y from 0 to 2, carried by node 1, which is
/// moved by 10 along x. It follows joint 2 at its foot and joint 3, one above, at its top; its
/// middle follows both alike. Joint 3 turns from 0 to 90 degrees about z in one second.
GltfFile bending_strip();

}  // namespace sightline::tests
