// Triangles as plain arrays.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace sightline::client {

using Vertex = std::array<float, 3>;
using Face = std::array<std::uint32_t, 3>;  ///< Indices of vertices.

/// The three indices of a face that holds no triangle: it keeps its number and is never hit.
inline constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

}  // namespace sightline::client
