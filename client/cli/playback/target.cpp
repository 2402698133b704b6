// Three ways to come to the ids of nodes.
#include "client/cli/playback/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "client/cli/exit_code.h"
#include "client/cli/playback/motion.h"
#include "client/cli/playback/scene_nodes.h"
#include "client/cli/progress_bar.h"
#include "client/scene_upload.h"

namespace sightline::client::cli::playback {
namespace {

Result<std::vector<std::uint64_t>> find_nodes(const Client& client, const StageRequest& request,
                                              const Motion& motion) {
  const auto nodes = list_nodes(client, request.scene);
  if (!nodes) return nodes.error();
  return match_nodes(motion, *nodes, request.under);
}

Result<std::vector<std::uint64_t>> place_nodes(const Client& client, const StageRequest& request,
                                               const Motion& motion, bool exists,
                                               const std::stop_token& stop) {
  ProgressBar bar("uploading");
  const auto show = [&](std::uint64_t done, std::uint64_t total) {
    bar.update(static_cast<double>(done) / static_cast<double>(total));
  };
  const SceneUploadOptions options{.by_node = motion.mobilities(), .stop = stop};
  if (exists) {
    return add_to_scene(client, request.scene, motion.scene, request.under, options, show);
  }
  const auto uploaded = upload_scene(client, request.scene, motion.scene, options, show);
  if (!uploaded) return uploaded.error();
  return find_nodes(client, request, motion);
}

// Takes the ids away from what is not to move.
Status keep_only(const StageRequest& request, const Motion& motion, Stage& stage) {
  std::set<std::uint32_t> moving(motion.placed.begin(), motion.placed.end());
  moving.insert(motion.shaped.begin(), motion.shaped.end());
  std::set<std::uint32_t> kept;
  for (const std::string& word : request.only) {
    const std::size_t before = kept.size();
    for (const std::uint32_t node : moving) {
      const bool is_meant =
          word == motion.scene.nodes[node].name || word == std::to_string(stage.ids[node]);
      if (is_meant) kept.insert(node);
    }
    if (kept.size() > before) continue;
    return local_error(fmt::format("the animation moves no node '{}'", word));
  }
  if (request.only.empty()) kept = std::move(moving);
  for (std::uint32_t i = 0; i < stage.ids.size(); ++i) {
    if (!kept.contains(i)) stage.ids[i] = 0;
    if (stage.ids[i] != 0 && (stage.first_moved == 0 || stage.ids[i] < stage.first_moved))
      stage.first_moved = stage.ids[i];
  }
  const auto count = [&](const std::vector<std::uint32_t>& nodes) {
    return static_cast<std::size_t>(
        std::count_if(nodes.begin(), nodes.end(), [&](auto node) { return kept.contains(node); }));
  };
  stage.placed = count(motion.placed);
  stage.shaped = count(motion.shaped);
  return {};
}

Status check(const StageRequest& request, bool exists) {
  if (exists && request.must_be_new) {
    return Error{Code::kAlreadyExists, fmt::format("scene {} exists", request.scene),
                 "SCENE_EXISTS"};
  }
  if (!exists && (request.under != 0 || request.add)) {
    return Error{Code::kNotFound, fmt::format("there is no scene {} to add to", request.scene),
                 "SCENE_NOT_FOUND"};
  }
  return {};
}

}  // namespace

importer::ImportOptions frame_of(const SceneInfo& scene) {
  importer::ImportOptions options;
  if (scene.up_axis != UpAxis::kUnknown) options.up_axis = scene.up_axis;
  if (scene.meters_per_unit > 0) options.meters_per_unit = scene.meters_per_unit;
  return options;
}

Result<Stage> set_stage(const Client& client, const StageRequest& request, const Motion& motion,
                        bool exists, const std::stop_token& stop) {
  if (const Status good = check(request, exists); !good) return good.error();
  auto ids = exists && !request.add ? find_nodes(client, request, motion)
                                    : place_nodes(client, request, motion, exists, stop);
  if (!ids) return ids.error();
  Stage stage{.ids = *std::move(ids), .is_new = !exists};
  if (const Status kept = keep_only(request, motion, stage); !kept) return kept.error();
  return stage;
}

}  // namespace sightline::client::cli::playback
