// Checks the server's rules before anything is sent.
#include "client/calls/scene_check.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace sightline::client::calls {
namespace {

Status check_transforms(const importer::ImportedScene& scene) {
  for (const importer::ImportedNode& node : scene.nodes) {
    for (const double number : node.parent_from_local) {
      if (std::isfinite(number)) continue;
      return Error{Code::kInvalidArgument,
                   fmt::format("node '{}': its transform holds {}, which is not finite", node.name,
                               std::isnan(number) ? "nan"
                               : number > 0       ? "inf"
                                                  : "-inf"),
                   {}};
    }
  }
  return {};
}

Status check_depth(const importer::ImportedScene& scene, std::uint32_t limit) {
  std::vector<std::uint32_t> depths;
  depths.reserve(scene.nodes.size());
  for (const importer::ImportedNode& node : scene.nodes) {
    depths.push_back(node.parent == importer::kNone ? 1 : depths[node.parent] + 1);
    if (depths.back() <= limit) continue;
    return Error{
        Code::kInvalidArgument,
        fmt::format("node '{}' is at depth {}, the limit is {}", node.name, depths.back(), limit),
        {}};
  }
  return {};
}

}  // namespace

Status check_scene(const importer::ImportedScene& scene, const ServerInfo& limits) {
  if (Status good = check_transforms(scene); !good) return good;
  if (Status good = check_depth(scene, limits.max_depth); !good) return good;
  for (const importer::ImportedMesh& mesh : scene.meshes) {
    if (mesh.faces.size() <= limits.max_triangles_per_mesh) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("mesh '{}' has {} faces, the limit is {}", mesh.name,
                             mesh.faces.size(), limits.max_triangles_per_mesh),
                 {}};
  }
  return {};
}

}  // namespace sightline::client::calls
