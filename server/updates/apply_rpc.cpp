// SceneService.ApplyUpdates: applies one batch on the scene's write queue.
#include "server/updates/apply_rpc.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/updates/update_codec.h"

namespace sightline::server::updates {
namespace {

/// Whether the request adds or removes nodes. Such requests are rare, so they are logged at level
/// info.
bool changes_content(const v1::ApplyUpdatesRequest& request) {
  return std::any_of(
      request.updates().begin(), request.updates().end(),
      [](const v1::Update& update) { return update.has_put_node() || update.has_delete_node(); });
}

/// Decodes the batch on any worker, then applies it on the write queue. The second of two requests
/// with one id finds the answer of the first there.
class ApplyCall final : public grpc::ServerUnaryReactor {
 public:
  ApplyCall(const scenes::Services& services, grpc::CallbackServerContext& context,
            const v1::ApplyUpdatesRequest& request, v1::ApplyUpdatesResponse& reply)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        request_(request),
        reply_(reply) {}

  void start() {
    auto work = services_.quotas.begin_work(caller_, 0, request_.ByteSizeLong());
    if (!work) return end(work.error());
    quota_ = std::move(*work);
    auto ticket = services_.admission.admit(caller_, 0, request_.SpaceUsedLong());
    if (!ticket) return end(ticket.error());
    ticket_ = std::move(*ticket);
    services_.compute.enqueue_update([this] {
      if (const Status ready = exec::to_status([this] { return prepare(); }); !ready)
        return end(ready);
      scene_->write_queue().post(services_.compute,
                                 [this] { end(exec::to_status([this] { return apply(); })); });
    });
  }

  void OnCancel() override { cancelled_.store(true, std::memory_order_relaxed); }
  void OnDone() override { delete this; }

 private:
  Status prepare() {
    auto scene = services_.find(request_.scene());
    if (!scene) return scene.error();
    if (Status good = scenes::check_request_id(request_.request_id()); !good) return good;
    scene_ = std::move(*scene);
    // A decode error is reported later: a repeated request gets its first answer instead.
    updates_.emplace(decode_updates(request_.updates(), services_.blobs));
    if (!request_.request_id().empty())
      content_ = std::hash<std::string>()(request_.SerializeAsString());
    return {};
  }

  Status apply() {
    if (cancelled_.load(std::memory_order_relaxed))
      return Error{Code::kCancelled, "the call was cancelled", "CANCELLED"};
    const std::string& id = request_.request_id();
    if (!id.empty()) {
      const auto before = scene_->answers().find(id, content_);
      if (!before) return before.error();
      if (*before != nullptr) {
        answer(**before);
        reply_.set_replayed(true);
        return {};
      }
    }
    if (!*updates_) return updates_->error();
    const std::size_t count = (*updates_)->size();
    scenes::RequestAnswers::Entry entry;
    const auto record = [&](const scenegraph::Applied& next) {
      answer(next);
      if (!id.empty()) entry = scene_->answers().prepare(id, content_, next);
    };
    auto applied = scene_->apply(
        std::move(**updates_), services_.compute,
        {.expected_revision = expected(), .before_publish = record, .cancelled = &cancelled_});
    if (!applied) return applied.error();
    if (!id.empty()) scene_->answers().retain(std::move(entry));
    log(applied->revision, count);
    return {};
  }

  std::optional<std::uint64_t> expected() const {
    if (!request_.has_expected_revision()) return std::nullopt;
    return request_.expected_revision();
  }

  void answer(const scenegraph::Applied& applied) {
    encode_revision(scene_->token(applied.revision), *reply_.mutable_revision());
    reply_.mutable_nodes()->Assign(applied.nodes.begin(), applied.nodes.end());
  }

  void log(std::uint64_t revision, std::size_t count) const {
    spdlog::log(changes_content(request_) ? spdlog::level::info : spdlog::level::debug,
                "event=scene_updated scene={} revision={} updates={}{}", scene_->info().name,
                revision, count, exec::request_id_of(context_));
  }

  void end(const Status& status) {
    // The update is applied: an error would say that it is not.
    if (status.ok()) {
      held_ = services_.unread.hold_in_any_case(
          context_, caller_, request_.ByteSizeLong() + 2 * reply_.ByteSizeLong());
    }
    const grpc::Status answer = exec::to_grpc(status);
    ticket_ = {};
    quota_ = {};
    updates_.reset();
    scene_.reset();
    exec::log_rpc("ApplyUpdates", context_, answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const v1::ApplyUpdatesRequest& request_;
  v1::ApplyUpdatesResponse& reply_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;
  exec::Admission::Ticket ticket_;
  exec::Quotas::Use quota_;
  std::shared_ptr<scenes::StoredScene> scene_;
  std::optional<Result<std::vector<scenegraph::model::Update>>> updates_;
  std::uint64_t content_ = 0;
  std::atomic<bool> cancelled_{false};
};

}  // namespace

grpc::ServerUnaryReactor* start_apply(const scenes::Services& services,
                                      grpc::CallbackServerContext& context,
                                      const v1::ApplyUpdatesRequest& request,
                                      v1::ApplyUpdatesResponse& reply) {
  auto* call = new ApplyCall(services, context, request, reply);
  call->start();
  return call;
}

}  // namespace sightline::server::updates
