// SceneService.
#include "server/updates/scene_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/exec/rpc_status.h"
#include "server/exec/unary_rpc.h"
#include "server/scenes/names.h"
#include "server/updates/apply_rpc.h"
#include "server/updates/scene_codec.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server::updates {
namespace {

void encode(scenes::StoredScene& scene, v1::Scene& out) {
  const scenegraph::revision::SceneSummary summary = scene.summary();
  encode_scene(scene.info(), scene.token(summary.revision), summary, out);
}

}  // namespace

Status SceneRpc::create(const v1::CreateSceneRequest& request, v1::CreateSceneResponse& reply) {
  auto info = decode_scene(request.scene());
  if (!info) return info.error();
  const auto scene = services_.scenes.create(std::move(*info));
  if (!scene) return scene.error();
  encode(**scene, *reply.mutable_scene());
  spdlog::info("event=scene_created scene={}", (*scene)->info().name);
  return {};
}

Status SceneRpc::get(const v1::GetSceneRequest& request, v1::GetSceneResponse& reply) {
  const auto scene = services_.find(request.name());
  if (!scene) return scene.error();
  encode(**scene, *reply.mutable_scene());
  return {};
}

Status SceneRpc::list(const v1::ListScenesRequest& request, v1::ListScenesResponse& reply) {
  if (Status good = scenes::check_project_name(request.parent()); !good) return good;
  if (request.page_size() < 0) {
    return Error{Code::kInvalidArgument,
                 fmt::format("page_size is {}, expected 0 to {}", request.page_size(), kMaxPage),
                 "BAD_PAGE_SIZE"};
  }
  const std::string& token = request.page_token();
  if (!token.empty() &&
      (!scenes::check_scene_name(token) || scenes::project_of(token) != request.parent())) {
    return Error{
        Code::kInvalidArgument,
        fmt::format("page_token {} is not from a list of {}", exec::quote(token), request.parent()),
        "BAD_PAGE_TOKEN"};
  }
  const int size =
      request.page_size() == 0 ? kDefaultPage : std::min(request.page_size(), kMaxPage);
  const scenes::ScenePage page =
      services_.scenes.list(request.parent(), token, static_cast<std::size_t>(size));
  for (const auto& scene : page.scenes) encode(*scene, *reply.add_scenes());
  reply.set_next_page_token(page.next);
  return {};
}

Status SceneRpc::remove(const v1::DeleteSceneRequest& request) {
  if (Status good = scenes::check_scene_name(request.name()); !good) return good;
  if (Status removed = services_.scenes.remove(request.name()); !removed) return removed;
  spdlog::info("event=scene_deleted scene={}", request.name());
  return {};
}

Status SceneRpc::stats(const v1::GetSceneStatsRequest& request, v1::GetSceneStatsResponse& reply) {
  const auto scene = services_.find(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = (*scene)->snapshot();
  encode_stats((*scene)->token(snapshot->revision()),
               scenegraph::revision::summarize_build(*snapshot), reply);
  return {};
}

grpc::ServerUnaryReactor* SceneRpc::CreateScene(grpc::CallbackServerContext* context,
                                                const v1::CreateSceneRequest* request,
                                                v1::CreateSceneResponse* reply) {
  return answer_in_arena("CreateScene", *context, *request, services_.compute, services_.admission,
                         [=, this] { return create(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::GetScene(grpc::CallbackServerContext* context,
                                             const v1::GetSceneRequest* request,
                                             v1::GetSceneResponse* reply) {
  return answer_in_arena("GetScene", *context, *request, services_.compute, services_.admission,
                         [=, this] { return get(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ListScenes(grpc::CallbackServerContext* context,
                                               const v1::ListScenesRequest* request,
                                               v1::ListScenesResponse* reply) {
  return answer_in_arena("ListScenes", *context, *request, services_.compute, services_.admission,
                         [=, this] { return list(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::DeleteScene(grpc::CallbackServerContext* context,
                                                const v1::DeleteSceneRequest* request,
                                                v1::DeleteSceneResponse*) {
  return answer_in_arena("DeleteScene", *context, *request, services_.compute, services_.admission,
                         [=, this] { return remove(*request); });
}

grpc::ServerUnaryReactor* SceneRpc::BatchGetNodes(grpc::CallbackServerContext* context,
                                                  const v1::BatchGetNodesRequest* request,
                                                  v1::BatchGetNodesResponse* reply) {
  return start_get_nodes(services_, *context, *request, *reply);
}

grpc::ServerUnaryReactor* SceneRpc::ApplyUpdates(grpc::CallbackServerContext*,
                                                 const v1::ApplyUpdatesRequest* request,
                                                 v1::ApplyUpdatesResponse* reply) {
  return start_apply(services_, *request, *reply);
}

grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>*
SceneRpc::StreamUpdates(grpc::CallbackServerContext*) {
  return start_update_stream(services_);
}

grpc::ServerWriteReactor<v1::WatchSceneResponse>* SceneRpc::WatchScene(
    grpc::CallbackServerContext*, const v1::WatchSceneRequest* request) {
  return start_watch(services_, *request);
}

grpc::ServerUnaryReactor* SceneRpc::GetSceneStats(grpc::CallbackServerContext* context,
                                                  const v1::GetSceneStatsRequest* request,
                                                  v1::GetSceneStatsResponse* reply) {
  return answer_in_arena("GetSceneStats", *context, *request, services_.compute,
                         services_.admission, [=, this] { return stats(*request, *reply); });
}

}  // namespace sightline::server::updates
