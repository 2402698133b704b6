// Finds an instance by reading nodes, and copies it by its mesh.
#include "client/load/moving_copy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace sightline::client::load {
namespace {

constexpr std::uint64_t kNodesPerRequest = 512;

struct Nodes {
  std::optional<NodeInfo> instance;
  std::vector<std::uint64_t> left_over;  // copies of earlier runs
};

// Ids are given from 1 upward; those of deleted nodes stay unused.
Result<Nodes> read_nodes(const Client& client, const SceneInfo& scene) {
  Nodes read;
  std::uint64_t seen = 0, unused = 0;
  std::vector<std::uint64_t> ids(kNodesPerRequest);
  constexpr std::uint64_t kMostUnused = 1'000'000;
  for (std::uint64_t first = 1; seen < scene.nodes && unused < kMostUnused;
       first += kNodesPerRequest) {
    std::iota(ids.begin(), ids.end(), first);
    const auto nodes = client.get_nodes(scene.name, ids);
    if (!nodes) return nodes.error();
    for (const NodeInfo& node : *nodes) {
      ++(node.id == 0 ? unused : seen);
      const bool is_copy = node.name == MovingCopy::kName;
      if (is_copy) read.left_over.push_back(node.id);
      if (node.mesh_digest.empty() || is_copy || read.instance) continue;
      read.instance = node;
    }
  }
  return read;
}

Transform moved(Transform transform, double x, double y) {
  transform[3] += x;
  transform[7] += y;
  return transform;
}

}  // namespace

Result<MovingCopy> MovingCopy::add(const Client& client, const std::string& scene) {
  const auto info = client.get_scene(scene);
  if (!info) return info.error();
  const auto nodes = read_nodes(client, *info);
  if (!nodes) return nodes.error();
  if (!nodes->instance || !info->bounds)
    return Error{Code::kFailedPrecondition, "the scene has no instance to move", "NO_INSTANCE"};
  const NodeInfo& original = *nodes->instance;
  const auto& bounds = *info->bounds;
  const double radius =
      0.01 * std::hypot(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2]);
  std::vector<Update> updates;
  for (const std::uint64_t node : nodes->left_over) updates.emplace_back(DeleteNode{.node = node});
  updates.emplace_back(PutNode{.node = -1,
                               .parent = original.parent,
                               .name = kName,
                               .parent_from_local = moved(original.parent_from_local, radius, 0),
                               .mesh_digest = original.mesh_digest,
                               .mobility = Mobility::kRigid,
                               .labels = original.labels});
  const auto applied = client.apply(scene, updates);
  if (!applied) return applied.error();
  return MovingCopy(client, scene, applied->nodes.front(), original.parent_from_local, radius);
}

MovingCopy::MovingCopy(MovingCopy&& other) noexcept
    : client_(other.client_),
      scene_(std::move(other.scene_)),
      node_(std::exchange(other.node_, 0)),
      middle_(other.middle_),
      radius_(other.radius_),
      steps_(other.steps_.load()) {}

MovingCopy::~MovingCopy() {
  if (node_ == 0) return;
  const std::array<Update, 1> updates{DeleteNode{.node = node_}};
  static_cast<void>(client_->apply(scene_, updates));
}

Status MovingCopy::move(const Client& client) {
  constexpr double kStepsPerTurn = 64;
  const double angle = 2 * std::numbers::pi * static_cast<double>(++steps_) / kStepsPerTurn;
  SetTransforms update;
  update.nodes.push_back(node_);
  update.parent_from_local.push_back(
      moved(middle_, radius_ * std::cos(angle), radius_ * std::sin(angle)));
  const std::array<Update, 1> updates{std::move(update)};
  const auto applied = client.apply(scene_, updates);
  if (!applied) return applied.error();
  return {};
}

}  // namespace sightline::client::load
