// Finds, adds or imports the nodes of a motion.
#include "client/cli/playback/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "client/cli/nodes.h"
#include "client/cli/playback/motion.h"
#include "client/cli/terminal.h"
#include "client/scene_upload.h"

namespace sightline::client::cli::playback {
namespace {

Error mismatch(std::string message) {
  return {Code::kFailedPrecondition, std::move(message), "SCENE_MISMATCH"};
}

std::string path_of(const importer::ImportedScene& scene, std::uint32_t node) {
  std::string path = scene.nodes[node].name;
  while ((node = scene.nodes[node].parent) != importer::kNone) {
    path.insert(0, scene.nodes[node].name + "/");
  }
  return path;
}

// Whether the motion needs each node: it moves, or a descendant moves.
std::vector<bool> needed(const Motion& motion) {
  std::vector<bool> out(motion.scene.nodes.size());
  for (const auto* list : {&motion.placed, &motion.shaped}) {
    for (std::uint32_t node : *list) {
      for (; node != importer::kNone && !out[node]; node = motion.scene.nodes[node].parent)
        out[node] = true;
    }
  }
  return out;
}

// Nodes that are not matched yet, by parent and name, in the order of their ids.
class Candidates {
 public:
  explicit Candidates(const std::vector<NodeInfo>& nodes) {
    for (const NodeInfo& node : nodes) lists_[{node.parent, node.name}].push_back(&node);
  }

  const NodeInfo* claim(std::uint64_t parent, const std::string& name, bool has_mesh) {
    const auto list = lists_.find({parent, name});
    if (list == lists_.end()) return nullptr;
    const auto found =
        std::find_if(list->second.begin(), list->second.end(),
                     [&](const NodeInfo* node) { return node->mesh_digest.empty() != has_mesh; });
    if (found == list->second.end()) return nullptr;
    const NodeInfo* const node = *found;
    list->second.erase(found);
    return node;
  }

 private:
  std::map<std::pair<std::uint64_t, std::string>, std::vector<const NodeInfo*>> lists_;
};

Status check_meshes(const Motion& motion, const std::vector<const NodeInfo*>& found) {
  const std::vector<std::string> digests = mesh_digests(motion.scene);
  for (const std::uint32_t node : motion.shaped) {
    if (found[node]->mesh_digest == digests[motion.scene.nodes[node].mesh]) continue;
    return mismatch(
        fmt::format("node {} '{}' of the scene has another mesh than in the file: it was "
                    "not imported from this file",
                    found[node]->id, path_of(motion.scene, node)));
  }
  return {};
}

Result<std::vector<std::uint64_t>> find_nodes(const Client& client, const TargetRequest& request,
                                              const Motion& motion) {
  const auto nodes = list_nodes(client, request.scene);
  if (!nodes) return nodes.error();
  const auto under = request.under.empty() ? Result<std::uint64_t>(std::uint64_t{0})
                                           : find_node(*nodes, request.under);
  if (!under) return under.error();
  return match_nodes(motion, *nodes, *under);
}

Result<std::vector<std::uint64_t>> add_nodes(const Client& client, const TargetRequest& request,
                                             const Motion& motion, bool exists,
                                             const std::stop_token& stop) {
  ProgressBar bar("uploading");
  const auto show = [&](std::uint64_t done, std::uint64_t total) {
    bar.update(static_cast<double>(done) / static_cast<double>(total));
  };
  const SceneUploadOptions options{.by_node = motion.mobilities(), .stop = stop};
  if (exists) {
    const auto under = resolve_node(client, request.scene, request.under);
    if (!under) return under.error();
    return add_to_scene(client, request.scene, motion.scene, *under, options, show);
  }
  const auto uploaded = upload_scene(client, request.scene, motion.scene, options, show);
  if (!uploaded) return uploaded.error();
  return find_nodes(client, request, motion);
}

// Sets the ids of nodes that must not move to 0.
Status keep_only(const TargetRequest& request, const Motion& motion, PlaybackTarget& target) {
  std::set<std::uint32_t> moving(motion.placed.begin(), motion.placed.end());
  moving.insert(motion.shaped.begin(), motion.shaped.end());
  std::set<std::uint32_t> kept;
  for (const std::string& word : request.only) {
    const std::size_t before = kept.size();
    for (const std::uint32_t node : moving) {
      const bool is_meant =
          word == motion.scene.nodes[node].name || word == std::to_string(target.ids[node]);
      if (is_meant) kept.insert(node);
    }
    if (kept.size() > before) continue;
    return local_error(fmt::format("the animation moves no node '{}'", word));
  }
  if (request.only.empty()) kept = std::move(moving);
  for (std::uint32_t i = 0; i < target.ids.size(); ++i) {
    if (!kept.contains(i)) target.ids[i] = 0;
    if (target.ids[i] != 0 && (target.first_moved == 0 || target.ids[i] < target.first_moved))
      target.first_moved = target.ids[i];
  }
  const auto count = [&](const std::vector<std::uint32_t>& nodes) {
    return static_cast<std::size_t>(
        std::count_if(nodes.begin(), nodes.end(), [&](auto node) { return kept.contains(node); }));
  };
  target.placed = count(motion.placed);
  target.shaped = count(motion.shaped);
  return {};
}

Status check(const TargetRequest& request, bool exists) {
  if (exists && request.must_be_new) {
    return Error{Code::kAlreadyExists, fmt::format("scene {} exists", request.scene),
                 "SCENE_EXISTS"};
  }
  if (!exists && (!request.under.empty() || request.add)) {
    return Error{Code::kNotFound, fmt::format("there is no scene {} to add to", request.scene),
                 "SCENE_NOT_FOUND"};
  }
  return {};
}

}  // namespace

Result<std::vector<std::uint64_t>> match_nodes(const Motion& motion,
                                               const std::vector<NodeInfo>& nodes,
                                               std::uint64_t under) {
  const importer::ImportedScene& scene = motion.scene;
  const std::vector<bool> must_be = needed(motion);
  Candidates candidates(nodes);
  std::vector<const NodeInfo*> found(scene.nodes.size(), nullptr);
  std::vector<std::uint64_t> ids(scene.nodes.size(), 0);
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const importer::ImportedNode& node = scene.nodes[i];
    const bool is_root = node.parent == importer::kNone;
    const std::uint64_t parent = is_root ? under : ids[node.parent];
    if (is_root || parent != 0)
      found[i] = candidates.claim(parent, node.name, node.mesh != importer::kNone);
    if (found[i] != nullptr) ids[i] = found[i]->id;
    if (found[i] != nullptr || !must_be[i]) continue;
    return mismatch(
        fmt::format("the scene has no node '{}'{}, which the animation needs: it was not "
                    "imported from this file, or has changed since",
                    path_of(scene, i), node.mesh != importer::kNone ? " with a mesh" : ""));
  }
  if (const Status same = check_meshes(motion, found); !same) return same.error();
  return ids;
}

importer::ImportOptions frame_of(const SceneInfo& scene) {
  importer::ImportOptions options;
  if (scene.up_axis != UpAxis::kUnknown) options.up_axis = scene.up_axis;
  if (scene.meters_per_unit > 0) options.meters_per_unit = scene.meters_per_unit;
  return options;
}

Result<PlaybackTarget> prepare_target(const Client& client, const TargetRequest& request,
                                      const Motion& motion, bool exists,
                                      const std::stop_token& stop) {
  if (const Status good = check(request, exists); !good) return good.error();
  auto ids = exists && !request.add ? find_nodes(client, request, motion)
                                    : add_nodes(client, request, motion, exists, stop);
  if (!ids) return ids.error();
  PlaybackTarget target{.ids = *std::move(ids), .is_new = !exists};
  if (const Status kept = keep_only(request, motion, target); !kept) return kept.error();
  return target;
}

}  // namespace sightline::client::cli::playback
