// SceneService.BatchGetNodes: nodes of one revision, by id.
#include "server/updates/nodes_rpc.h"

#include <fmt/format.h>
#include <grpcpp/server_context.h>

#include <memory>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/scenes/revision_wait.h"
#include "server/updates/scene_codec.h"

namespace sightline::server::updates {
namespace {

class NodesCall final : public grpc::ServerUnaryReactor {
 public:
  NodesCall(const scenes::Services& services, const v1::BatchGetNodesRequest& request,
            v1::BatchGetNodesResponse& reply)
      : services_(services),
        wait_(std::make_shared<scenes::RevisionWait>(services.compute, services.admission,
                                                     services.waiting_reads)),
        request_(request),
        reply_(reply) {}

  void start(const grpc::CallbackServerContext& context) {
    if (const Status good = exec::to_status([this] { return open(); }); !good) return end(good);
    wait_->read(scene_, request_.consistency(), context.deadline(), request_.ByteSizeLong(),
                [this](Result<scenes::RevisionWait::SnapshotPointer> pinned) {
                  if (!pinned) return end(pinned.error());
                  services_.compute.enqueue([this, snapshot = std::move(*pinned)] {
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
    auto scene = services_.find(request_.scene());
    if (!scene) return scene.error();
    auto ticket = services_.admission.admit(0, request_.SpaceUsedLong());
    if (!ticket) return ticket.error();
    scene_ = std::move(*scene);
    ticket_ = std::move(*ticket);
    return {};
  }

  Status answer(const scenegraph::revision::Snapshot& snapshot) {
    encode_revision(scene_->token(snapshot.revision()), *reply_.mutable_served());
    for (const std::uint64_t id : request_.ids()) {
      v1::Node& node = *reply_.add_nodes();
      if (const scenegraph::model::Node* found = snapshot.find(id)) encode_node(*found, node);
    }
    return {};
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    ticket_ = {};
    scene_.reset();
    exec::log_rpc("BatchGetNodes", answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  const v1::BatchGetNodesRequest& request_;
  v1::BatchGetNodesResponse& reply_;
  std::shared_ptr<scenes::StoredScene> scene_;
  exec::Admission::Ticket ticket_;
};

}  // namespace

grpc::ServerUnaryReactor* start_get_nodes(const scenes::Services& services,
                                          const grpc::CallbackServerContext& context,
                                          const v1::BatchGetNodesRequest& request,
                                          v1::BatchGetNodesResponse& reply) {
  auto* call = new NodesCall(services, request, reply);
  call->start(context);
  return call;
}

}  // namespace sightline::server::updates
