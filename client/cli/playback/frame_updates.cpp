// The last frame, kept to compare with.
#include "client/cli/playback/frame_updates.h"

#include <utility>

namespace sightline::client::cli::playback {

std::vector<Update> FrameUpdates::make(const importer::Pose& pose) {
  std::vector<Update> updates;
  SetTransforms set;
  for (const importer::Pose::Placed& placed : pose.placed) {
    const std::uint64_t id = ids_[placed.node];
    if (id == 0) continue;
    const auto [known, is_new] = transforms_.try_emplace(id, placed.parent_from_local);
    if (!is_new && known->second == placed.parent_from_local) continue;
    known->second = placed.parent_from_local;
    set.nodes.push_back(static_cast<NodeRef>(id));
    set.parent_from_local.push_back(placed.parent_from_local);
  }
  if (!set.nodes.empty()) updates.emplace_back(std::move(set));
  for (const importer::Pose::Shaped& shaped : pose.shaped) {
    PatchVertices patch;
    for (const std::uint32_t node : shaped.nodes) {
      if (ids_[node] != 0) patch.nodes.push_back(static_cast<NodeRef>(ids_[node]));
    }
    if (patch.nodes.empty()) continue;
    std::vector<Vertex>& known = vertices_[static_cast<std::uint64_t>(patch.nodes[0])];
    if (known == shaped.vertices) continue;
    known = shaped.vertices;
    patch.positions = shaped.vertices;
    updates.emplace_back(std::move(patch));
  }
  return updates;
}

void FrameUpdates::forget() {
  transforms_.clear();
  vertices_.clear();
}

}  // namespace sightline::client::cli::playback
