// SceneService.
#include "server/scene_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/in_quotes.h"
#include "server/names.h"
#include "server/scene_codec.h"
#include "server/unary_rpc.h"

namespace sightline::server {
namespace {

/// A change of what is in the scene, not merely of where it is: rare enough for the log.
bool changes_content(const v1::ApplyUpdatesRequest& request) {
  return std::any_of(request.updates().begin(), request.updates().end(),
                     [](const v1::Update& update) { return !update.has_set_transforms(); });
}

}  // namespace

Result<std::shared_ptr<StoredScene>> SceneRpc::find(const std::string& name) const {
  if (const Status good = check_scene_name(name); !good) return good.error();
  return scenes_.get(name);
}

Status SceneRpc::create(const v1::CreateSceneRequest& request, v1::CreateSceneResponse& reply) {
  auto info = decode_scene(request.scene());
  if (!info) return info.error();
  const auto scene = scenes_.create(std::move(*info));
  if (!scene) return scene.error();
  encode_scene((*scene)->info(), (*scene)->summary(), *reply.mutable_scene());
  spdlog::info("event=scene_created scene={}", (*scene)->info().name);
  return {};
}

Status SceneRpc::get(const v1::GetSceneRequest& request, v1::GetSceneResponse& reply) {
  const auto scene = find(request.name());
  if (!scene) return scene.error();
  encode_scene((*scene)->info(), (*scene)->summary(), *reply.mutable_scene());
  return {};
}

Status SceneRpc::list(const v1::ListScenesRequest& request, v1::ListScenesResponse& reply) {
  if (Status good = check_project_name(request.parent()); !good) return good;
  if (request.page_size() < 0) {
    return Error{Code::kInvalidArgument,
                 fmt::format("page_size is {}, expected 0 to {}", request.page_size(), kMaxPage),
                 "BAD_PAGE_SIZE"};
  }
  const std::string& token = request.page_token();
  if (!token.empty() && (!check_scene_name(token) || project_of(token) != request.parent())) {
    return Error{
        Code::kInvalidArgument,
        fmt::format("page_token {} is not from a list of {}", in_quotes(token), request.parent()),
        "BAD_PAGE_TOKEN"};
  }
  const int size =
      request.page_size() == 0 ? kDefaultPage : std::min(request.page_size(), kMaxPage);
  const ScenePage page = scenes_.list(request.parent(), token, static_cast<std::size_t>(size));
  for (const auto& scene : page.scenes)
    encode_scene(scene->info(), scene->summary(), *reply.add_scenes());
  reply.set_next_page_token(page.next);
  return {};
}

Status SceneRpc::remove(const v1::DeleteSceneRequest& request) {
  if (Status good = check_scene_name(request.name()); !good) return good;
  if (Status removed = scenes_.remove(request.name()); !removed) return removed;
  spdlog::info("event=scene_deleted scene={}", request.name());
  return {};
}

Status SceneRpc::get_nodes(const v1::BatchGetNodesRequest& request,
                           v1::BatchGetNodesResponse& reply) {
  if (request.ids_size() > kMaxNodesPerRequest) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the request has {} ids, the limit is {}", request.ids_size(),
                             kMaxNodesPerRequest),
                 "TOO_MANY_NODES"};
  }
  const auto scene = find(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = (*scene)->scene().snapshot();
  for (const std::uint64_t id : request.ids()) {
    v1::Node& node = *reply.add_nodes();
    if (const scenegraph::Node* found = snapshot->find(id)) encode_node(*found, node);
  }
  return {};
}

Status SceneRpc::apply(const v1::ApplyUpdatesRequest& request, v1::ApplyUpdatesResponse& reply) {
  const auto scene = find(request.scene());
  if (!scene) return scene.error();
  const auto updates = decode_updates(request, blobs_);
  if (!updates) return updates.error();
  const auto expected = request.has_expected_revision()
                            ? std::optional<std::uint64_t>(request.expected_revision())
                            : std::nullopt;
  const auto applied = (*scene)->scene().apply(*updates, expected);
  if (!applied) return applied.error();
  reply.mutable_revision()->set_revision(applied->revision);
  reply.mutable_nodes()->Assign(applied->nodes.begin(), applied->nodes.end());
  spdlog::log(changes_content(request) ? spdlog::level::info : spdlog::level::debug,
              "event=scene_updated scene={} revision={} updates={}", request.scene(),
              applied->revision, updates->size());
  return {};
}

Status SceneRpc::stats(const v1::GetSceneStatsRequest& request, v1::GetSceneStatsResponse& reply) {
  const auto scene = find(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = (*scene)->scene().snapshot();
  encode_stats(snapshot->revision(), scenegraph::summarize_build(*snapshot), reply);
  return {};
}

grpc::ServerUnaryReactor* SceneRpc::CreateScene(grpc::CallbackServerContext* context,
                                                const v1::CreateSceneRequest* request,
                                                v1::CreateSceneResponse* reply) {
  return answer_in_arena("CreateScene", *context, *request, compute_, admission_,
                         [=, this] { return create(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::GetScene(grpc::CallbackServerContext* context,
                                             const v1::GetSceneRequest* request,
                                             v1::GetSceneResponse* reply) {
  return answer_in_arena("GetScene", *context, *request, compute_, admission_,
                         [=, this] { return get(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ListScenes(grpc::CallbackServerContext* context,
                                               const v1::ListScenesRequest* request,
                                               v1::ListScenesResponse* reply) {
  return answer_in_arena("ListScenes", *context, *request, compute_, admission_,
                         [=, this] { return list(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::DeleteScene(grpc::CallbackServerContext* context,
                                                const v1::DeleteSceneRequest* request,
                                                v1::DeleteSceneResponse*) {
  return answer_in_arena("DeleteScene", *context, *request, compute_, admission_,
                         [=, this] { return remove(*request); });
}

grpc::ServerUnaryReactor* SceneRpc::BatchGetNodes(grpc::CallbackServerContext* context,
                                                  const v1::BatchGetNodesRequest* request,
                                                  v1::BatchGetNodesResponse* reply) {
  return answer_in_arena("BatchGetNodes", *context, *request, compute_, admission_,
                         [=, this] { return get_nodes(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ApplyUpdates(grpc::CallbackServerContext* context,
                                                 const v1::ApplyUpdatesRequest* request,
                                                 v1::ApplyUpdatesResponse* reply) {
  return answer_in_arena("ApplyUpdates", *context, *request, compute_, admission_,
                         [=, this] { return apply(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::GetSceneStats(grpc::CallbackServerContext* context,
                                                  const v1::GetSceneStatsRequest* request,
                                                  v1::GetSceneStatsResponse* reply) {
  return answer_in_arena("GetSceneStats", *context, *request, compute_, admission_,
                         [=, this] { return stats(*request, *reply); });
}

}  // namespace sightline::server
