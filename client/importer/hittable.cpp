// Looks for one triangle that can be hit, and counts what there is instead.
#include "client/importer/hittable.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/importer/extension.h"
#include "client/importer/finite.h"

namespace sightline::client::importer {
namespace {

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

struct Counts {
  std::uint64_t vertices = 0, triangles = 0, lines_and_points = 0;
  std::uint64_t points = 0;  // vertices of meshes that have points, or no faces
  std::uint64_t placed = 0;  // triangles of meshes that nodes have
  std::uint64_t finite = 0;  // placed triangles without a bad vertex
  bool hittable = false;
};

void count(const ImportedMesh& mesh, Counts& counts) {
  counts.vertices += mesh.vertices.size();
  counts.triangles += mesh.triangles;
  counts.lines_and_points += mesh.lines_and_points;
  // A line has two vertices, which no other line shares.
  if (mesh.faces.empty() || mesh.lines_and_points == mesh.vertices.size())
    counts.points += mesh.vertices.size();
}

void count_placed(const ImportedMesh& mesh, Counts& counts) {
  for (const Face& face : mesh.faces) {
    if (face[0] == kNoVertex || counts.hittable) continue;
    ++counts.placed;
    const Vertex &a = mesh.vertices[face[0]], &b = mesh.vertices[face[1]],
                 &c = mesh.vertices[face[2]];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    ++counts.finite;
    counts.hittable = has_area(a, b, c);
  }
}

Counts counts_of(const ImportedScene& scene) {
  Counts counts;
  std::vector<bool> seen(scene.meshes.size());
  for (const ImportedNode& node : scene.nodes) {
    if (node.mesh == kNone || seen[node.mesh]) continue;
    seen[node.mesh] = true;
    count_placed(scene.meshes[node.mesh], counts);
  }
  for (const ImportedMesh& mesh : scene.meshes) count(mesh, counts);
  return counts;
}

}  // namespace

std::string why_not_hittable(const ImportedScene& scene, std::string_view file) {
  const Counts counts = counts_of(scene);
  if (counts.hittable) return {};
  if (counts.finite > 0) return fmt::format("none of its {} triangles has an area", counts.finite);
  if (counts.placed > 0) {
    return fmt::format("each of its {} triangles has a vertex that is not finite", counts.placed);
  }
  if (counts.triangles > 0)
    return fmt::format("no node has one of its {} triangles", counts.triangles);
  if (counts.points > 0)
    return fmt::format("it is a point cloud: {} points, and no faces", counts.points);
  if (counts.lines_and_points > 0)
    return fmt::format("it has {} lines and points, and no triangle", counts.lines_and_points);
  if (extension_of(file) == "stl") return "it is an empty STL file: it has no facets";
  return "it has no triangles";
}

}  // namespace sightline::client::importer
