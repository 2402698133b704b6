// One loop for each mode.
#include "client/importer/gltf/faces.h"

#include <initializer_list>

namespace sightline::client::importer::gltf {
namespace {

void add(Polygons& faces, std::initializer_list<std::uint32_t> corners) {
  faces.corners.insert(faces.corners.end(), corners);
  faces.first.push_back(static_cast<std::uint32_t>(faces.corners.size()));
}

}  // namespace

Polygons faces_of(Mode mode, std::span<const std::uint32_t> v) {
  Polygons faces;
  const std::size_t n = v.size();
  switch (mode) {
    case Mode::kPoints:
      for (const std::uint32_t vertex : v) add(faces, {vertex});
      break;
    case Mode::kLines:
      for (std::size_t i = 0; i + 1 < n; i += 2) add(faces, {v[i], v[i + 1]});
      break;
    case Mode::kLineLoop:
    case Mode::kLineStrip:
      for (std::size_t i = 0; i + 1 < n; ++i) add(faces, {v[i], v[i + 1]});
      if (mode == Mode::kLineLoop && n > 1) add(faces, {v[n - 1], v[0]});
      break;
    case Mode::kTriangles:
      faces.first.reserve(n / 3 + 1);
      faces.corners.reserve(n);
      for (std::size_t i = 0; i + 2 < n; i += 3) add(faces, {v[i], v[i + 1], v[i + 2]});
      break;
    case Mode::kTriangleStrip:
      for (std::size_t i = 0; i + 2 < n; ++i) {
        const std::size_t turned = i % 2;
        add(faces, {v[i + turned], v[i + 1 - turned], v[i + 2]});
      }
      break;
    case Mode::kTriangleFan:
      for (std::size_t i = 1; i + 1 < n; ++i) add(faces, {v[0], v[i], v[i + 1]});
      break;
  }
  return faces;
}

std::size_t left_over(Mode mode, std::size_t indices) {
  if (mode == Mode::kLines) return indices % 2;
  if (mode == Mode::kTriangles) return indices % 3;
  const std::size_t fewest = mode == Mode::kPoints ? 1 : mode < Mode::kTriangles ? 2 : 3;
  return indices < fewest ? indices : 0;
}

}  // namespace sightline::client::importer::gltf
