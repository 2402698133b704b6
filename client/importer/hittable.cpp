// Looks for one triangle that can be hit, and counts what there is instead.
#include "client/importer/hittable.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/importer/extension.h"

namespace sightline::client::importer {
namespace {

bool has_finite_corner(const Vertex& v) {
  return std::all_of(v.begin(), v.end(), [](float x) { return std::isfinite(x); });
}

// Whether a triangle has an area. It rounds, so that a file of nothing but slivers of a width below
// 1e-15 of their length may seem to have none.
bool has_area(const Vertex& a, const Vertex& b, const Vertex& c) {
  std::array<double, 3> ab{}, ac{};
  for (std::size_t k = 0; k < 3; ++k) {
    ab[k] = static_cast<double>(b[k]) - static_cast<double>(a[k]);
    ac[k] = static_cast<double>(c[k]) - static_cast<double>(a[k]);
  }
  return ab[1] * ac[2] != ab[2] * ac[1] || ab[2] * ac[0] != ab[0] * ac[2] ||
         ab[0] * ac[1] != ab[1] * ac[0];
}

struct Contents {
  std::uint64_t vertices = 0, triangles = 0, lines_and_points = 0;
  std::uint64_t points = 0;  // vertices of meshes that have points, or no faces
  std::uint64_t placed = 0;  // triangles of meshes that nodes have
  std::uint64_t finite = 0;  // placed triangles without a bad vertex
  bool hittable = false;
};

void count(const ImportedMesh& mesh, Contents& contents) {
  contents.vertices += mesh.vertices.size();
  contents.triangles += mesh.triangles;
  contents.lines_and_points += mesh.lines_and_points;
  // A line has two vertices, which no other line shares.
  if (mesh.faces.empty() || mesh.lines_and_points == mesh.vertices.size())
    contents.points += mesh.vertices.size();
}

void count_placed(const ImportedMesh& mesh, Contents& contents) {
  for (const Face& face : mesh.faces) {
    if (face[0] == kNoVertex || contents.hittable) continue;
    ++contents.placed;
    const Vertex &a = mesh.vertices[face[0]], &b = mesh.vertices[face[1]],
                 &c = mesh.vertices[face[2]];
    if (!has_finite_corner(a) || !has_finite_corner(b) || !has_finite_corner(c)) continue;
    ++contents.finite;
    contents.hittable = has_area(a, b, c);
  }
}

Contents contents_of(const ImportedScene& scene) {
  Contents contents;
  std::vector<bool> seen(scene.meshes.size());
  for (const ImportedNode& node : scene.nodes) {
    if (node.mesh == kNone || seen[node.mesh]) continue;
    seen[node.mesh] = true;
    count_placed(scene.meshes[node.mesh], contents);
  }
  for (const ImportedMesh& mesh : scene.meshes) count(mesh, contents);
  return contents;
}

}  // namespace

std::string why_not_hittable(const ImportedScene& scene, std::string_view file) {
  const Contents contents = contents_of(scene);
  if (contents.hittable) return {};
  if (contents.finite > 0)
    return fmt::format("none of its {} triangles has an area", contents.finite);
  if (contents.placed > 0) {
    return fmt::format("each of its {} triangles has a vertex that is not finite", contents.placed);
  }
  if (contents.triangles > 0)
    return fmt::format("no node has one of its {} triangles", contents.triangles);
  if (contents.points > 0)
    return fmt::format("it is a point cloud: {} points, and no faces", contents.points);
  if (contents.lines_and_points > 0)
    return fmt::format("it has {} lines and points, and no triangle", contents.lines_and_points);
  if (extension_of(file) == "stl") return "it is an empty STL file: it has no facets";
  return "it has no triangles";
}

}  // namespace sightline::client::importer
