// SceneService.ApplyUpdates: applies one batch on the scene's write queue.
#include "server/updates/apply_rpc.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "server/blobs/digest.h"
#include "server/codec/update_codec.h"
#include "server/exec/arena_messages.h"
#include "server/exec/rpc_status.h"
#include "server/scenes/write_errors.h"
#include "server/updates/producer_messages.h"

namespace sightline::server::updates {
namespace {

/// Whether the request adds or removes nodes. Such requests are rare, so they are logged at level
/// info.
bool changes_content(const v1::ApplyUpdatesRequest& request) {
  return std::any_of(
      request.updates().begin(), request.updates().end(),
      [](const v1::Update& update) { return update.has_put_node() || update.has_delete_node(); });
}

/// A digest that is the same for every build of the server: scenes keep it.
std::uint64_t digest_of(const std::string& bytes) {
  blobs::Sha256 sha;
  sha.update(std::as_bytes(std::span(bytes)));
  const blobs::Sha256Sum sum = sha.finish();
  std::uint64_t digest = 0;
  std::memcpy(&digest, sum.data(), sizeof(digest));
  return digest;
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
    auto ticket = services_.admission.admit(caller_, 0, exec::bytes_on_arena(request_));
    if (!ticket) return end(ticket.error());
    ticket_ = std::move(*ticket);
    begin();
  }

  void OnCancel() override { cancelled_.store(true, std::memory_order_relaxed); }
  void OnDone() override { delete this; }

 private:
  void begin() {
    services_.compute.enqueue_update(exec::flow_of(caller_, request_.scene()), [this] {
      if (const Status ready = exec::to_status([this] { return prepare(); }); !ready)
        return end(ready);
      scene_->write_queue().post(services_.compute, [this] { run(); });
    });
  }

  Status prepare() {
    auto scene = services_.find(request_.scene());
    if (!scene) return scene.error();
    if (Status good = scenes::check_request_id(request_.request_id()); !good) return good;
    scene_ = std::move(*scene);
    if (Status loaded = scene_->load(services_.compute); !loaded) return loaded;
    // A decode error is reported later: a repeated request gets its first answer instead.
    updates_.emplace(codec::decode_updates(request_.updates(), services_.blobs));
    if (!request_.request_id().empty()) content_ = digest_of(request_.SerializeAsString());
    return {};
  }

  /// Runs on the write queue.
  void run() {
    const Status begun = exec::to_status([this] { return apply(); });
    if (!begun) not_applied(begun);  // else answered() ends the call, perhaps already
  }

  /// Where other servers write, too, the request is refused only once it is known what they have
  /// committed, and that none of them has got it before.
  void not_applied(const Status& why) {
    scenes::SceneFollower* const follower = scene_->follower();
    if (follower == nullptr || scene_->removed() || caught_up_ ||
        scenes::says_nothing_of_the_batch(why.error()))
      return refuse(why);
    caught_up_ = true;
    follower->when_caught_up(services_.compute, [this, follower](const Status& read) {
      const std::string& id = request_.request_id();
      const Status known =
          exec::to_status([&] { return !read || id.empty() ? read : follower->look_up(id); });
      if (!known) return refuse(known);
      run();
    });
  }

  /// Another server may have made another scene in place of this one: asks once.
  void refuse(const Status& why) {
    const bool gone = scene_->follower() != nullptr && scene_->removed();
    if (!gone || std::exchange(looked_up_, true)) return end(why);
    caught_up_ = false;
    begin();
  }

  Status apply() {
    if (cancelled_.load(std::memory_order_relaxed))
      return Error{Code::kCancelled, "the call was cancelled", "CANCELLED"};
    // answered() may end the call, and with it this object, before the members of the scene return.
    const std::shared_ptr<scenes::StoredScene> scene = scene_;
    const std::string id = request_.request_id();
    if (!id.empty()) {
      const auto repeat = scene->find_earlier(
          id, content_,
          [this](const scenegraph::Applied& earlier, const Result<scenes::Durability>& durability) {
            encode_applied(earlier);
            reply_.set_replayed(true);
            answered(durability);
          });
      if (!repeat) return repeat.error();
      if (*repeat) return {};
    }
    if (!*updates_) return updates_->error();
    const auto encode = [this](const scenegraph::Applied& next) { encode_applied(next); };
    const auto applied = scene->try_apply(
        **updates_, services_.compute,
        {.expected_revision = expected(), .before_publish = encode, .cancelled = &cancelled_},
        {.request_id = id,
         .content = content_,
         .answer = [this](const Result<scenes::Durability>& durability) { answered(durability); },
         .repeated =
             [this](const scenegraph::Applied& earlier) {
               encode_applied(earlier);
               reply_.set_replayed(true);
             }});
    return applied ? Status() : Status(applied.error());
  }

  /// Runs on the write queue, when the updates are kept, or cannot be.
  void answered(const Result<scenes::Durability>& durability) {
    if (!durability) return refuse(durability.error());
    reply_.set_durability(encode_durability(*durability));
    log();
    end({});
  }

  std::optional<std::uint64_t> expected() const {
    if (!request_.has_expected_revision()) return std::nullopt;
    return request_.expected_revision();
  }

  void encode_applied(const scenegraph::Applied& applied) {
    encode_revision(scene_->token(applied.revision), *reply_.mutable_revision());
    reply_.mutable_nodes()->Assign(applied.nodes.begin(), applied.nodes.end());
  }

  void log() const {
    if (reply_.replayed()) return;
    spdlog::log(changes_content(request_) ? spdlog::level::info : spdlog::level::debug,
                "event=scene_updated scene={} revision={} updates={}{}", scene_->info().name,
                reply_.revision().revision(), request_.updates_size(),
                exec::request_id_of(context_));
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
  bool caught_up_ = false;  // with other servers, before the request is refused
  bool looked_up_ = false;  // the scene, after it was removed
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
