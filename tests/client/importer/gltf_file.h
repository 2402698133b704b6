// A small glTF file built from numbers.
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
  /// The same with unsigned shorts.
  int add_shorts(const std::vector<std::uint16_t>& rows, const std::string& type);
  /// Adds a channel that animates `path` (translation, rotation, scale, weights) of a node.
  void animate(int node, const std::string& path, const std::vector<float>& seconds,
               const std::vector<float>& values);

  std::string text() const;

  nlohmann::json json;  ///< The caller fills all but buffers, bufferViews and accessors.

 private:
  int add_bytes(std::string_view bytes, int component, std::size_t rows, const std::string& type);

  std::string bytes_;
};

/// A node 1 with a triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0), under a root 0.
GltfFile triangle_under_root();

/// A strip of four triangles in x from -0.5 to 0.5, y from 0 to 2, in node 1, which is moved by 10
/// along x. Its foot follows joint 2, its top joint 3, one unit above, and its middle both equally.
/// Joint 3 rotates from 0 to 90 degrees about z in one second.
GltfFile bending_strip();

}  // namespace sightline::tests
