// BackupService: a stream of parts in each direction, one at a time.
#include "server/durable/backup_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "server/blobs/blob_rpc.h"
#include "server/durable/backup_reader.h"
#include "server/durable/restorer.h"
#include "server/exec/malformed.h"
#include "server/exec/rpc_status.h"
#include "server/exec/unread_replies.h"
#include "server/scenes/names.h"

namespace sightline::server::durable {
namespace {

Error not_durable() {
  return {Code::kFailedPrecondition,
          "the server keeps scenes in memory only; start it with --data-dir or --store",
          "NOT_DURABLE"};
}

/// Errors: kInvalidArgument, a text that is no digest; kResourceExhausted, too many.
Result<std::set<blobs::BlobDigest>> digests_of(const v1::BackupRequest& request) {
  if (request.known_meshes_size() > blobs::kMaxDigestsPerRequest) {
    return Error{Code::kResourceExhausted,
                 fmt::format("{} known meshes in a request, at most {} are taken",
                             request.known_meshes_size(), blobs::kMaxDigestsPerRequest),
                 "TOO_MANY_DIGESTS"};
  }
  std::set<blobs::BlobDigest> digests;
  for (const std::string& text : request.known_meshes()) {
    const auto digest = blobs::BlobDigest::parse(text);
    if (!digest) return digest.error();
    digests.insert(*digest);
  }
  return digests;
}

/// Reads a part and writes it, in turn. Deletes itself.
class BackupCall final : public grpc::ServerWriteReactor<v1::BackupResponse> {
 public:
  BackupCall(const BackupRpc::Parts& parts, grpc::CallbackServerContext& context,
             const v1::BackupRequest& request)
      : parts_(parts),
        context_(context),
        caller_(exec::caller_of(context)),
        scene_(request.scene()),
        known_(digests_of(request)) {}

  void start() {
    if (!known_) return end(known_.error());
    const Status entered = parts_.calls.enter(this, caller_, {.on_stop = [this] { stop_ = true; }});
    if (!entered) return end(entered);
    work([this] { return begin(); });
  }

  void OnWriteDone(bool ok) override {
    held_.reset();
    if (!ok) return end(cancelled());
    work([] { return Status(); });
  }
  void OnCancel() override { stop_ = true; }
  void OnDone() override {
    held_.reset();  // before the context goes
    parts_.calls.leave(this);
    delete this;
  }

 private:
  static Error cancelled() { return {Code::kCancelled, "the call was cancelled", "CANCELLED"}; }

  /// Calls first(), then writes the next part or ends the call.
  template <class First>
  void work(First first) {
    parts_.services.compute.enqueue_background([this, first] {
      bool more = false;
      const Status done = exec::to_status([&]() -> Status {
        if (stop_) return parts_.calls.stopped() ? parts_.calls.stopped_error() : cancelled();
        if (Status begun = first(); !begun) return begun;
        return read(more);
      });
      if (!done || !more) return end(done);
      StartWrite(&reply_);
    });
  }

  Status begin() {
    if (parts_.store == nullptr) return not_durable();
    if (!scene_.empty()) {
      if (Status good = scenes::check_scene_name(scene_); !good) return good;
    }
    reader_.emplace(*parts_.store, scene_, *std::move(known_));
    return reader_->begin();
  }

  Status read(bool& more) {
    const auto read = reader_->next(*reply_.mutable_part());
    if (!read) return read.error();
    more = *read;
    if (!more) return {};
    auto held = parts_.services.unread.hold(context_, caller_, reply_.ByteSizeLong());
    if (!held) return held.error();
    held_ = std::move(*held);
    return {};
  }

  void end(const Status& status) {
    held_.reset();
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("Backup", context_, answer, begun_);
    Finish(answer);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const BackupRpc::Parts parts_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const std::string scene_;
  Result<std::set<blobs::BlobDigest>> known_;  // until the reader has it
  std::atomic<bool> stop_{false};
  std::optional<BackupReader> reader_;
  v1::BackupResponse reply_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // while reply_ is written
};

/// Reads a part and takes it, in turn. Deletes itself.
class RestoreCall final : public grpc::ServerReadReactor<v1::RestoreRequest> {
 public:
  RestoreCall(const BackupRpc::Parts& parts, grpc::CallbackServerContext& context,
              v1::RestoreResponse& reply)
      : parts_(parts), context_(context), caller_(exec::caller_of(context)), reply_(reply) {}

  void start() {
    const auto cancel = [this] { context_.TryCancel(); };
    const Status entered =
        parts_.calls.enter(this, caller_, {.on_stop = cancel, .on_late = cancel}, &peer_);
    if (!entered) return end(entered);
    if (parts_.store == nullptr) return end(not_durable());
    read();
  }

  void OnReadDone(bool ok) override {
    peer_.end();
    parts_.services.compute.enqueue_background([this, ok] {
      const Status taken = exec::to_status([&] { return ok ? take() : finish(); });
      if (!ok || !taken) return end(taken);
      read();
    });
  }
  void OnDone() override {
    parts_.calls.leave(this);
    delete this;
  }

 private:
  void read() {
    exec::before_read(request_);
    peer_.begin(exec::kIdleStream);
    StartRead(&request_);
  }

  Status take() {
    auto ticket = parts_.services.admission.admit(caller_, 0, request_.SpaceUsedLong());
    if (!ticket) return ticket.error();
    if (!restorer_) {
      if (!request_.scene().empty()) {
        if (Status good = scenes::check_scene_name(request_.scene()); !good) return good;
      }
      restorer_.emplace(
          Restorer::Parts{parts_.services.scenes, parts_.services.blobs, parts_.memory, caller_},
          Restorer::Wanted{request_.scene(), request_.revision()});
    }
    return restorer_->take(request_.part());
  }

  Status finish() {
    if (Status ended = exec::end_of_reads(request_); !ended) return ended;
    if (context_.IsCancelled())
      return Error{Code::kCancelled, "the call was cancelled", "CANCELLED"};
    if (!restorer_) return exec::invalid_argument("there are no parts", "EMPTY_BACKUP");
    return restorer_->finish();
  }

  void end(const Status& status) {
    if (restorer_) {
      for (const Restorer::Restored& restored : restorer_->restored()) add_answer(restored);
      restorer_.reset();  // before the client knows
    }
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("Restore", context_, answer, begun_);
    Finish(answer);
  }

  void add_answer(const Restorer::Restored& restored) {
    v1::RestoredScene& scene = *reply_.add_scenes();
    scene.set_name(restored.scene);
    scenes::encode_revision(restored.revision, *scene.mutable_revision());
    spdlog::info("event=scene_restored scene={} revision={}{}", restored.scene,
                 restored.revision.revision, exec::call_ids_of(context_));
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const BackupRpc::Parts parts_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  v1::RestoreResponse& reply_;
  exec::PeerWait peer_;
  v1::RestoreRequest request_;
  std::optional<Restorer> restorer_;
};

}  // namespace

grpc::ServerWriteReactor<v1::BackupResponse>* BackupRpc::Backup(
    grpc::CallbackServerContext* context, const v1::BackupRequest* request) {
  auto* call = new BackupCall(parts_, *context, *request);
  call->start();
  return call;
}

grpc::ServerReadReactor<v1::RestoreRequest>* BackupRpc::Restore(
    grpc::CallbackServerContext* context, v1::RestoreResponse* reply) {
  auto* call = new RestoreCall(parts_, *context, *reply);
  call->start();
  return call;
}

}  // namespace sightline::server::durable
