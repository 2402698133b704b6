// A leaf block: a few triangles over shared vertices, in consecutive 32-bit words.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/vec3.h"

namespace sightline::accel::blocks {

inline constexpr std::size_t kBlockTriangles = 16;
inline constexpr std::size_t kBlockVertices = 16;

/// Reads a block of T triangles and V vertices, both at least 1. Its words, a multiple of four:
///
///   1          T, and V in the second byte
///   3 V        floats: all x, all y, all z, relative to the center of the frame (frame.h)
///   3 ceil(T/4)  bytes: the first corner of every triangle, an index of a vertex; then, each from
///   a
///              whole word on, the second corners and the third. The rest of a word is zero.
///   T          ids of the triangles, in no order
///   the rest   zeros
///
/// Readers may load whole vectors: the owner of the words makes kBlockSlack bytes behind the last
/// one readable. Any thread may read.
struct Block {
  explicit Block(const std::uint32_t* words)
      : triangles(words[0] & 0xff),
        vertices(words[0] >> 8 & 0xff),
        x(reinterpret_cast<const float*>(words + 1)),
        y(x + vertices),
        z(y + vertices),
        corners_(reinterpret_cast<const std::uint8_t*>(words + 1 + 3 * std::size_t{vertices})),
        ids_(words + 1 + 3 * std::size_t{vertices} + 3 * corner_words(triangles)) {}

  /// Size of a block of this many triangles and vertices.
  static constexpr std::size_t words(std::size_t triangles, std::size_t vertices) {
    return (1 + 3 * vertices + 3 * corner_words(triangles) + triangles + 3) / 4 * 4;
  }
  std::size_t words() const { return words(triangles, vertices); }

  /// Corner k, 0 to 2, of every triangle.
  const std::uint8_t* corner(std::size_t k) const {
    return corners_ + sizeof(std::uint32_t) * k * corner_words(triangles);
  }
  std::uint32_t id(std::size_t triangle) const { return ids_[triangle]; }
  /// Vertex i, relative to the center of the frame.
  geometry::Vec3f vertex(std::size_t i) const { return {x[i], y[i], z[i]}; }

  /// Size of one corner of all triangles, in words.
  static constexpr std::size_t corner_words(std::size_t triangles) { return (triangles + 3) / 4; }

  unsigned triangles, vertices;
  const float *x, *y, *z;  ///< The coordinates of all vertices.

 private:
  const std::uint8_t* corners_;
  const std::uint32_t* ids_;
};

/// Bytes behind a block that readers may load, and ignore.
inline constexpr std::size_t kBlockSlack = 64;

}  // namespace sightline::accel::blocks
