// A small glTF file built from numbers.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sightline::tests {

class GltfFile {
 public:
  GltfFile();

  /// Adds an accessor of `rows.size() / width` rows and returns its number; `type` is SCALAR, VEC3,
  /// VEC4 or MAT4. T is the type of a component.
  template <class T>
  int add(const std::vector<T>& rows, const std::string& type) {
    return add_bytes({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(T)},
                     component<T>(), rows.size() / width_of(type), type);
  }
  int add(std::initializer_list<float> rows, const std::string& type) {
    return add(std::vector<float>(rows), type);
  }
  int add_shorts(const std::vector<std::uint16_t>& rows, const std::string& type) {
    return add(rows, type);
  }
  int add_bytes(std::string_view bytes, int component, std::size_t rows, const std::string& type);
  /// Adds bytes as a buffer view and returns its number.
  int add_view(std::string_view bytes);
  /// Adds a channel that animates `path` (translation, rotation, scale, weights) of a node.
  void animate(int node, const std::string& path, const std::vector<float>& seconds,
               const std::vector<float>& values);

  std::string text() const;
  /// With the buffer in a chunk of its own.
  std::string glb() const;

  nlohmann::json json;  ///< The caller fills all but buffers, bufferViews and accessors.

 private:
  template <class T>
  static constexpr int component() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    if constexpr (std::is_same_v<T, float>) return 5126;
    if constexpr (std::is_same_v<T, double>) return 5130;
  }
  static std::size_t width_of(const std::string& type);

  std::string bytes_;
};

/// A node 1 with a triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0), under a root 0.
GltfFile triangle_under_root();

/// A strip of four triangles in x from -0.5 to 0.5, y from 0 to 2, in node 1, which is moved by 10
/// along x. Its foot follows joint 2, its top joint 3, one unit above, and its middle both equally.
/// Joint 3 rotates from 0 to 90 degrees about z in one second.
GltfFile bending_strip();

}  // namespace sightline::tests
