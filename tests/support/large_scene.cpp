// A grid of nodes, group by group.
#include "tests/support/large_scene.h"

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"

namespace sightline::tests {

using scenegraph::model::Affine;
using scenegraph::model::NodeId;
using scenegraph::model::NodeRef;

namespace {

constexpr double kSpacing = 4;  // A mesh is about two units wide

std::size_t side_of(std::size_t count) {
  return static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
}

Affine moved(double x, double y, double z) { return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}}; }

}  // namespace

// Groups are first.
NodeId LargeScene::id(std::size_t n) const { return groups + n + 1; }

// Nodes are on a grid within their group, groups on a grid of such grids.
struct LargeScene::Raster {
  explicit Raster(const LargeScene& scene)
      : in_group(scene.groups == 0 ? scene.nodes : (scene.nodes + scene.groups - 1) / scene.groups),
        side(side_of(in_group)),
        groups_side(side_of(std::max<std::size_t>(scene.groups, 1))) {}

  Affine group(std::size_t g) const {
    const double width = kSpacing * static_cast<double>(side + 1);
    return moved(width * static_cast<double>(g % groups_side), 0,
                 width * static_cast<double>(g / groups_side));
  }

  std::size_t in_group, side, groups_side;
};

Affine LargeScene::transform(std::size_t n, std::uint64_t step) const {
  const Raster raster(*this);
  const std::size_t k = n % raster.in_group;
  const double wave = 0.02 * static_cast<double>((step + n) % 50);
  return moved(kSpacing * static_cast<double>(k % raster.side), wave,
               kSpacing * static_cast<double>(k / raster.side));
}

accel::geometry::Vec3d LargeScene::where(std::size_t n) const {
  const Raster raster(*this);
  const accel::geometry::Vec3d at = transform(n, 0).point({});
  return groups == 0 ? at : raster.group(n / raster.in_group).point(at);
}

std::vector<scenegraph::model::Update> LargeScene::batch(
    std::size_t first, std::size_t most, const std::vector<MeshChoice>& meshes) const {
  const Raster raster(*this);
  std::vector<scenegraph::model::Update> updates;
  for (std::size_t i = first; i < std::min(first + most, all_nodes()); ++i) {
    scenegraph::model::PutNode put;
    put.node = -1 - static_cast<NodeRef>(i);
    if (i < groups) {
      put.parent_from_local = raster.group(i);
    } else {
      const std::size_t n = i - groups;
      put.parent_from_local = transform(n, 0);
      if (groups > 0) {
        const std::size_t group = n / raster.in_group;
        put.parent =
            group >= first ? -1 - static_cast<NodeRef>(group) : static_cast<NodeRef>(group + 1);
      }
      const MeshChoice& choice = meshes[n % meshes.size()];
      put.mesh = choice.mesh;
      put.mesh_digest = choice.digest;
    }
    updates.emplace_back(std::move(put));
  }
  return updates;
}

scenegraph::model::SetTransforms LargeScene::move(std::size_t moving, bool random,
                                                  std::uint64_t step) const {
  Random draw(step);
  scenegraph::model::SetTransforms set;
  for (std::size_t k = 0; k < std::min(moving, nodes); ++k) {
    // These nodes, too, are spread over all groups.
    const std::size_t n = random ? draw.below(nodes) : k * (nodes / std::min(moving, nodes));
    set.nodes.push_back(static_cast<NodeRef>(id(n)));
    set.parent_from_local.push_back(transform(n, step + 1));
  }
  return set;
}

}  // namespace sightline::tests
