// Checks the server's rules before anything is sent.
#include "client/calls/scene_check.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace sightline::client::calls {
namespace {

// The condition number |A| |A^-1| of the linear part, by its cofactors. Infinite or NaN if there is
// no inverse.
double condition(const std::array<double, 12>& m) {
  const std::array<double, 9> a{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
  std::array<double, 9> cofactors{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto at = [&](std::size_t i, std::size_t j) {
        return a[(r + i) % 3 * 3 + (c + j) % 3];
      };
      cofactors[r * 3 + c] = at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1);
    }
  }
  const double determinant = a[0] * cofactors[0] + a[1] * cofactors[1] + a[2] * cofactors[2];
  const auto norm = [](const std::array<double, 9>& x) {
    double sum = 0;
    for (const double v : x) sum += v * v;
    return std::sqrt(sum);
  };
  return norm(a) * norm(cofactors) / std::abs(determinant);
}

Status check_transforms(const importer::ImportedScene& scene) {
  for (const importer::ImportedNode& node : scene.nodes) {
    const double k = condition(node.parent_from_local);
    if (k <= kMaxCondition) continue;
    return Error{
        Code::kInvalidArgument,
        fmt::format(
            "node '{}': its transform is singular, or nearly so (condition {:.3g}, limit {:.0e})",
            node.name, k, kMaxCondition),
        {}};
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
