// SceneService.PutScene: gathers the nodes of all messages, then names the scene.
#include "server/updates/put_scene_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "server/codec/update_codec.h"
#include "server/exec/call_context.h"
#include "server/exec/malformed.h"
#include "server/exec/rpc_status.h"
#include "server/scenes/update_log.h"
#include "server/updates/scene_codec.h"

namespace sightline::server::updates {
namespace {

/// A scene whose last message has not come. Only its call knows it.
struct UnfinishedScene {
  std::shared_ptr<scenes::StoredScene> draft;  ///< Has no nodes. Null before the first message.
  bool replace = false;
  std::vector<scenegraph::model::Update> nodes;
  std::vector<exec::MemoryAccount::Charge> charges;  ///< For the nodes.
};

/// Reads a message, takes it on a worker, and only then reads the next. Deletes itself.
class PutSceneCall final : public grpc::ServerReadReactor<v1::PutSceneRequest> {
 public:
  PutSceneCall(const scenes::Services& services, grpc::CallbackServerContext& context,
               v1::PutSceneResponse& reply)
      : services_(services), context_(context), caller_(exec::caller_of(context)), reply_(reply) {}

  void start() {
    const auto give_up = [this] {
      late_ = true;
      context_.TryCancel();
    };
    const Status entered = services_.scene_puts.enter(this, caller_, {.on_late = give_up}, &peer_);
    if (!entered) return end(entered);
    read();
  }

  void OnReadDone(bool ok) override {
    peer_.end();
    if (!ok) return end(why_unfinished());
    auto work = services_.quotas.begin_work(caller_, 0, request_.ByteSizeLong());
    if (!work) return end(work.error());
    quota_ = std::move(*work);
    auto ticket = services_.admission.admit(caller_, 0, request_.SpaceUsedLong());
    if (!ticket) return end(ticket.error());
    ticket_ = std::move(*ticket);
    services_.compute.enqueue_work(caller_, [this] {
      const Status taken = exec::to_status([this] { return take(); });
      ticket_ = {};
      if (taken && request_.finish()) return make_soon();
      quota_ = {};
      if (!taken) return end(taken);
      read();
    });
  }

  void OnDone() override {
    services_.scene_puts.leave(this);
    delete this;
  }

 private:
  void read() {
    exec::before_read(request_);
    peer_.begin(kPutTimeout);
    StartRead(&request_);
  }

  Error why_unfinished() const {
    if (const Status ended = exec::end_of_reads(request_); !ended) return ended.error();
    if (late_)
      return {Code::kAborted, "the next message did not come in time: put the scene again",
              "STREAM_IDLE"};
    if (context_.IsCancelled()) return {Code::kCancelled, "the call was cancelled", "CANCELLED"};
    return exec::invalid_argument("the call ended without `finish`: nothing was made",
                                  "NOT_FINISHED");
  }

  Status take() {
    if (scene_.draft == nullptr) {
      if (Status begun = begin(); !begun) return begun;
    } else if (request_.has_scene() || request_.replace()) {
      return exec::invalid_argument("only the first message may name the scene", "OPENED_TWICE");
    }
    auto nodes = codec::decode_nodes(request_.nodes(), services_.blobs, scene_.nodes.size());
    if (!nodes) return nodes.error();
    auto charge =
        scene_.draft->memory().reclaim_and_charge(exec::Held::kNodes, scenes::bytes_of(*nodes));
    if (!charge) return charge.error();
    scene_.charges.push_back(std::move(*charge));
    scene_.nodes.insert(scene_.nodes.end(), std::make_move_iterator(nodes->begin()),
                        std::make_move_iterator(nodes->end()));
    return {};
  }

  /// Refuses early what put() would refuse.
  Status begin() {
    auto info = decode_scene(request_.scene());
    if (!info) return info.error();
    const exec::Role role = request_.replace() ? exec::Role::kAdmin : exec::Role::kWrite;
    if (Status allowed = exec::check_role(context_, role, info->name); !allowed) return allowed;
    if (Status fits = services_.scenes.check_put(info->name, request_.replace()); !fits)
      return fits;
    scene_.replace = request_.replace();
    scene_.draft = services_.scenes.draft(std::move(*info));
    return {};
  }

  /// Waits for the disk, as a worker for updates may.
  void make_soon() {
    services_.compute.enqueue_update(exec::flow_of(caller_, scene_.draft->info().name), [this] {
      const Status made = exec::to_status([this] { return make(); });
      quota_ = {};
      end(made);
    });
  }

  Status make() {
    if (context_.IsCancelled()) return why_unfinished();
    const auto nodes = scene_.nodes.size();
    const auto applied = scene_.draft->apply(std::move(scene_.nodes), services_.compute);
    if (!applied) return applied.error();
    scene_.draft->drop_old_revisions();
    const auto summary = scene_.draft->summary();
    if (!summary) return summary.error();
    const auto scene = services_.scenes.put(scene_.draft, scene_.replace);
    if (!scene) return scene.error();
    const auto time =
        std::chrono::duration_cast<std::chrono::milliseconds>(exec::LogClock::now() - begun_);
    spdlog::info(
        "event=scene_put scene={} nodes={} meshes={} triangles={} bytes={} replace={} ms={}{}",
        (*scene)->info().name, nodes, summary->meshes, summary->triangles_unique,
        summary->bytes_geometry, scene_.replace, time.count(), exec::call_ids_of(context_));
    // It is made: if it cannot be read back now, its first reader is told why.
    static_cast<void>((*scene)->load(services_.compute));
    encode_scene((*scene)->info(), (*scene)->token(summary->revision), *summary,
                 *reply_.mutable_scene());
    return {};
  }

  void end(const Status& status) {
    scene_ = {};
    ticket_ = {};
    quota_ = {};
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("PutScene", context_, answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  v1::PutSceneResponse& reply_;
  exec::PeerWait peer_;
  std::atomic<bool> late_{false};
  v1::PutSceneRequest request_;
  exec::Admission::Ticket ticket_;
  exec::Quotas::Use quota_;
  UnfinishedScene scene_;
};

}  // namespace

grpc::ServerReadReactor<v1::PutSceneRequest>* start_put_scene(const scenes::Services& services,
                                                              grpc::CallbackServerContext& context,
                                                              v1::PutSceneResponse& reply) {
  auto* call = new PutSceneCall(services, context, reply);
  call->start();
  return call;
}

}  // namespace sightline::server::updates
