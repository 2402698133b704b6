// SceneService: reads and deletes scenes, and starts the calls that change and watch them.
#include "server/updates/scene_rpc.h"

#include <fmt/format.h>
#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "scenegraph/revision/deferred_cells.h"
#include "server/codec/node_codec.h"
#include "server/exec/call_context.h"
#include "server/exec/rpc_status.h"
#include "server/exec/unary_rpc.h"
#include "server/scenes/names.h"
#include "server/scenes/reclaim.h"
#include "server/scenes/revision_wait.h"
#include "server/updates/apply_rpc.h"
#include "server/updates/mesh_reader.h"
#include "server/updates/put_scene_rpc.h"
#include "server/updates/scene_codec.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server::updates {
namespace {

Status encode(scenes::StoredScene& scene, v1::Scene& out) {
  const auto summary = scene.summary();
  if (!summary) return summary.error();
  encode_scene(scene.info(), scene.token(summary->revision), *summary, out);
  return {};
}

/// A list loads no scene: there may be more than fit in memory. A scene that cannot be read does
/// not hide the others.
void encode_listed(scenes::StoredScene& scene, v1::Scene& out) {
  const std::optional<std::uint64_t> unread = scene.unread();
  if (!unread && encode(scene, out)) return;
  encode_info(scene.info(), out);
  encode_revision(scene.token(unread ? *unread : scene.snapshot()->revision()),
                  *out.mutable_head());
  out.set_unread(true);
}

/// Waits for the revision, then encodes the nodes on a worker. Deletes itself.
class NodesCall final : public grpc::ServerUnaryReactor {
 public:
  NodesCall(const scenes::Services& services, grpc::CallbackServerContext& context,
            const v1::BatchGetNodesRequest& request, v1::BatchGetNodesResponse& reply)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        wait_(std::make_shared<scenes::RevisionWait>(services.compute, services.admission,
                                                     services.waiting_reads)),
        request_(request),
        reply_(reply) {}

  void start() {
    if (const Status good = exec::to_status([this] { return open(); }); !good) return end(good);
    wait_->read(scene_, request_.consistency(), context_.deadline(), request_.ByteSizeLong(),
                caller_, [this](Result<scenes::RevisionWait::SnapshotPointer> pinned) {
                  if (!pinned) return end(pinned.error());
                  services_.compute.enqueue_management([this, snapshot = std::move(*pinned)] {
                    end(exec::to_status([&] { return answer(*snapshot); }));
                  });
                });
  }

  void OnCancel() override { wait_->cancel(); }
  void OnDone() override { delete this; }

 private:
  Status open() {
    if (request_.ids_size() > kMaxNodesPerRequest) {
      return Error{Code::kResourceExhausted,
                   fmt::format("the request has {} ids, the limit is {}", request_.ids_size(),
                               kMaxNodesPerRequest),
                   "TOO_MANY_NODES"};
    }
    auto scene = services_.find_for_read(request_.scene(), request_.consistency());
    if (!scene) return scene.error();
    auto work = services_.quotas.begin_work(caller_, 0, request_.ByteSizeLong());
    if (!work) return work.error();
    quota_ = std::move(*work);
    auto ticket = services_.admission.admit(caller_, 0, request_.SpaceUsedLong());
    if (!ticket) return ticket.error();
    scene_ = std::move(*scene);
    ticket_ = std::move(*ticket);
    return {};
  }

  Status answer(const scenegraph::revision::Snapshot& snapshot) {
    encode_revision(scene_->token(snapshot.revision()), *reply_.mutable_served());
    for (const std::uint64_t id : request_.ids()) {
      v1::Node& node = *reply_.add_nodes();
      if (const scenegraph::model::Node* found = snapshot.find(id))
        codec::encode_node(*found, node);
    }
    return {};
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(
        exec::hold_reply(services_.unread, context_, caller_, request_, reply_, status, held_));
    ticket_ = {};
    quota_ = {};
    scene_.reset();
    exec::log_rpc("BatchGetNodes", context_, answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  const v1::BatchGetNodesRequest& request_;
  v1::BatchGetNodesResponse& reply_;
  std::shared_ptr<scenes::StoredScene> scene_;
  exec::Admission::Ticket ticket_;
  exec::Quotas::Use quota_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;
};

}  // namespace

Status SceneRpc::create(const grpc::ServerContextBase& context,
                        const v1::CreateSceneRequest& request, v1::CreateSceneResponse& reply) {
  auto info = decode_scene(request.scene());
  if (!info) return info.error();
  const auto scene = services_.scenes.create(std::move(*info));
  if (!scene) return scene.error();
  if (Status encoded = encode(**scene, *reply.mutable_scene()); !encoded) return encoded;
  spdlog::info("event=scene_created scene={}{}", (*scene)->info().name, exec::call_ids_of(context));
  return {};
}

Status SceneRpc::get(const v1::GetSceneRequest& request, v1::GetSceneResponse& reply) {
  const auto scene = services_.find_loaded(request.name());
  if (!scene) return scene.error();
  return encode(**scene, *reply.mutable_scene());
}

Status SceneRpc::list(const grpc::CallbackServerContext& context,
                      const v1::ListScenesRequest& request, v1::ListScenesResponse& reply) {
  const bool all = request.parent() == scenes::kAllProjects;
  if (!all) {
    if (Status good = scenes::check_project_name(request.parent()); !good) return good;
  }
  if (request.page_size() < 0) {
    return Error{Code::kInvalidArgument,
                 fmt::format("page_size is {}, expected 0 to {}", request.page_size(), kMaxPage),
                 "BAD_PAGE_SIZE"};
  }
  const std::string& token = request.page_token();
  if (!token.empty() && (!scenes::check_scene_name(token) ||
                         (!all && scenes::project_of(token) != request.parent()))) {
    return Error{
        Code::kInvalidArgument,
        fmt::format("page_token {} is not from a list of {}", exec::quote(token), request.parent()),
        "BAD_PAGE_TOKEN"};
  }
  const int size =
      request.page_size() == 0 ? kDefaultPage : std::min(request.page_size(), kMaxPage);
  const scenes::ScenePage page = services_.scenes.list(
      request.parent(), token, static_cast<std::size_t>(size),
      [principal = exec::principal_of(context)](const std::string& name) {
        return principal == nullptr || principal->may(exec::Role::kRead, name);
      });
  for (const auto& scene : page.scenes) encode_listed(*scene, *reply.add_scenes());
  reply.set_next_page_token(page.next);
  return {};
}

Status SceneRpc::remove(const grpc::ServerContextBase& context,
                        const v1::DeleteSceneRequest& request) {
  if (Status good = scenes::check_scene_name(request.name()); !good) return good;
  if (Status removed = services_.scenes.remove(request.name()); !removed) return removed;
  spdlog::info("event=scene_deleted scene={}{}", request.name(), exec::call_ids_of(context));
  return {};
}

Status SceneRpc::stats(const v1::GetSceneStatsRequest& request, v1::GetSceneStatsResponse& reply) {
  const auto scene = services_.find_loaded(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = (*scene)->snapshot();
  encode_stats((*scene)->token(snapshot->revision()),
               scenegraph::revision::summarize_build(*snapshot), reply);
  return {};
}

Status SceneRpc::cool(const grpc::ServerContextBase& context, const v1::CoolSceneRequest& request,
                      v1::CoolSceneResponse& reply) {
  const auto scene = services_.find_loaded(request.scene());
  if (!scene) return scene.error();
  reply.set_bytes_freed((*scene)->drop_trees());
  scenes::free_dropped_trees();
  spdlog::info("event=scene_cooled scene={} bytes={}{}", request.scene(), reply.bytes_freed(),
               exec::call_ids_of(context));
  return {};
}

Status SceneRpc::deferred_cells(const v1::ListDeferredCellsRequest& request,
                                v1::ListDeferredCellsResponse& reply) {
  const auto scene = services_.find_loaded(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = (*scene)->snapshot();
  const std::uint32_t limit = request.max_cells() == 0
                                  ? kMaxDeferredCells
                                  : std::min(request.max_cells(), kMaxDeferredCells);
  const auto cells = scenegraph::revision::deferred_cells(*snapshot, limit);
  encode_revision((*scene)->token(snapshot->revision()), *reply.mutable_served());
  for (const auto& box : cells.boxes)
    reply.mutable_boxes()->append(reinterpret_cast<const char*>(box.data()), sizeof(box));
  reply.set_total(cells.total);
  return {};
}

SceneRpc::SceneRpc(const scenes::Services& services) : services_(services) {
  SetMessageAllocatorFor_ApplyUpdates(&batches_);
}

grpc::ServerUnaryReactor* SceneRpc::CreateScene(grpc::CallbackServerContext* context,
                                                const v1::CreateSceneRequest* request,
                                                v1::CreateSceneResponse* reply) {
  return answer_in_arena("CreateScene", *context, *request, *reply, services_.unary(),
                         [=, this] { return create(*context, *request, *reply); });
}

grpc::ServerReadReactor<v1::PutSceneRequest>* SceneRpc::PutScene(
    grpc::CallbackServerContext* context, v1::PutSceneResponse* reply) {
  return start_put_scene(services_, *context, *reply);
}

grpc::ServerUnaryReactor* SceneRpc::GetScene(grpc::CallbackServerContext* context,
                                             const v1::GetSceneRequest* request,
                                             v1::GetSceneResponse* reply) {
  return answer_in_arena("GetScene", *context, *request, *reply, services_.unary(),
                         [=, this] { return get(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ListScenes(grpc::CallbackServerContext* context,
                                               const v1::ListScenesRequest* request,
                                               v1::ListScenesResponse* reply) {
  return answer_in_arena("ListScenes", *context, *request, *reply, services_.unary(),
                         [=, this] { return list(*context, *request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::DeleteScene(grpc::CallbackServerContext* context,
                                                const v1::DeleteSceneRequest* request,
                                                v1::DeleteSceneResponse* reply) {
  return answer_in_arena("DeleteScene", *context, *request, *reply, services_.unary(),
                         [=, this] { return remove(*context, *request); });
}

grpc::ServerUnaryReactor* SceneRpc::BatchGetNodes(grpc::CallbackServerContext* context,
                                                  const v1::BatchGetNodesRequest* request,
                                                  v1::BatchGetNodesResponse* reply) {
  auto* call = new NodesCall(services_, *context, *request, *reply);
  call->start();
  return call;
}

grpc::ServerUnaryReactor* SceneRpc::ApplyUpdates(grpc::CallbackServerContext* context,
                                                 const v1::ApplyUpdatesRequest* request,
                                                 v1::ApplyUpdatesResponse* reply) {
  return start_apply(services_, *context, *request, *reply);
}

grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>*
SceneRpc::StreamUpdates(grpc::CallbackServerContext* context) {
  return start_update_stream(services_, *context);
}

grpc::ServerWriteReactor<v1::WatchSceneResponse>* SceneRpc::WatchScene(
    grpc::CallbackServerContext* context, const v1::WatchSceneRequest* request) {
  return start_watch(services_, *context, *request);
}

grpc::ServerUnaryReactor* SceneRpc::GetSceneStats(grpc::CallbackServerContext* context,
                                                  const v1::GetSceneStatsRequest* request,
                                                  v1::GetSceneStatsResponse* reply) {
  return answer_in_arena("GetSceneStats", *context, *request, *reply, services_.unary(),
                         [=, this] { return stats(*request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::CoolScene(grpc::CallbackServerContext* context,
                                              const v1::CoolSceneRequest* request,
                                              v1::CoolSceneResponse* reply) {
  return answer_in_arena("CoolScene", *context, *request, *reply, services_.unary(),
                         [=, this] { return cool(*context, *request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ReadMesh(grpc::CallbackServerContext* context,
                                             const v1::ReadMeshRequest* request,
                                             v1::ReadMeshResponse* reply) {
  return answer_in_arena("ReadMesh", *context, *request, *reply, services_.unary(),
                         [=, this] { return read_mesh(services_, *request, *reply); });
}

grpc::ServerUnaryReactor* SceneRpc::ListDeferredCells(grpc::CallbackServerContext* context,
                                                      const v1::ListDeferredCellsRequest* request,
                                                      v1::ListDeferredCellsResponse* reply) {
  return answer_in_arena("ListDeferredCells", *context, *request, *reply, services_.unary(),
                         [=, this] { return deferred_cells(*request, *reply); });
}

}  // namespace sightline::server::updates
