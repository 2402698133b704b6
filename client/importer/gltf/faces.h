// The faces that the indices of a primitive stand for. Internal to the importer.
#pragma once

#include <cstdint>
#include <span>

#include "client/importer/file_scene.h"

namespace sightline::client::importer::gltf {

/// How indices form faces, by its number in the format.
enum class Mode : std::uint8_t {
  kPoints,
  kLines,
  kLineLoop,
  kLineStrip,
  kTriangles,
  kTriangleStrip,
  kTriangleFan,
};

/// Points are faces with one corner, lines with two. All triangles of a strip or a fan have its
/// orientation, and those without area keep their number. Indices that are left over are ignored.
Polygons faces_of(Mode mode, std::span<const std::uint32_t> indices);

/// How many indices at the end form no face.
std::size_t left_over(Mode mode, std::size_t indices);

}  // namespace sightline::client::importer::gltf
