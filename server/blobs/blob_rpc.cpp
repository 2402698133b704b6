// BlobService: which meshes the server has, and uploads of them.
#include "server/blobs/blob_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "server/exec/caller.h"
#include "server/exec/malformed.h"
#include "server/exec/rpc_status.h"
#include "server/exec/unary_rpc.h"

namespace sightline::server::blobs {
namespace {

Status find_missing(const v1::FindMissingBlobsRequest& request, const BlobStore& blobs,
                    v1::FindMissingBlobsResponse& reply) {
  if (request.digests_size() > kMaxDigestsPerRequest) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the request has {} digests, the limit is {}", request.digests_size(),
                             kMaxDigestsPerRequest),
                 "TOO_MANY_DIGESTS"};
  }
  std::vector<BlobDigest> digests;
  digests.reserve(static_cast<std::size_t>(request.digests_size()));
  for (const std::string& text : request.digests()) {
    const auto digest = BlobDigest::parse(text);
    if (!digest) return digest.error();
    digests.push_back(*digest);
  }
  const std::vector<bool> there = blobs.has(digests);
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (!there[i]) reply.add_digests(request.digests(static_cast<int>(i)));
  }
  return {};
}

Status upload_status(const v1::GetUploadStatusRequest& request, const BlobStore& blobs,
                     v1::GetUploadStatusResponse& reply) {
  const auto digest = BlobDigest::parse(request.digest());
  if (!digest) return digest.error();
  const UploadStatus status = blobs.status(*digest);
  reply.set_committed_size(status.committed);
  reply.set_complete(status.complete);
  return {};
}

constexpr const char* kTooSlow = "UPLOAD_TOO_SLOW";

/// Whether a later call may continue the upload after this error.
bool leaves_upload_whole(const Error& error) {
  return error.code == Code::kOutOfRange || error.code == Code::kCancelled ||
         error.reason == exec::kQueueFull || error.reason == exec::kQuotaBytes ||
         error.reason == exec::kQuotaWork || error.reason == exec::kMemoryBudget ||
         error.reason == kTooSlow;
}

/// Reads a chunk, checks and copies it in the arena, and only then reads the next. Deletes itself.
class UploadReactor final : public grpc::ServerReadReactor<v1::UploadBlobRequest> {
 public:
  UploadReactor(BlobStore& blobs, exec::CallRegistry& uploads, const exec::UnaryParts& parts,
                grpc::CallbackServerContext& context, v1::UploadBlobResponse& reply)
      : blobs_(blobs),
        uploads_(uploads),
        parts_(parts),
        context_(context),
        caller_(exec::caller_of(context)),
        reply_(reply) {}

  void start() {
    const Status entered =
        uploads_.enter(this, caller_, {.on_late = [this] { end_slow(); }}, &progress_);
    if (!entered) return end(entered);
    progress_.begin(kUploadTimeout);
    read();
  }

  void OnReadDone(bool ok) override {
    if (!stop_reading()) return;  // end_slow() was first
    // A client that ends without `finish` may continue the upload later.
    if (!ok) return end(exec::end_of_reads(chunk_));
    // The quota and the ticket are released with the chunk.
    auto work = parts_.quotas.begin_work(caller_, 0, chunk_.ByteSizeLong());
    if (!work) {
      chunk_ = {};
      return end(work.error());
    }
    quota_ = std::move(*work);
    auto ticket = parts_.admission.admit(caller_, 0, chunk_.SpaceUsedLong());
    if (!ticket) {
      chunk_ = {};  // a refusal may wait: see RefusalPace
      return end(ticket.error());
    }
    ticket_ = std::move(*ticket);
    parts_.compute.enqueue_work(caller_, [this] {
      const Status accepted = exec::to_status([this] { return accept(); });
      ticket_ = {};
      quota_ = {};
      if (!accepted || done_) return end(accepted);
      note_progress();
      read();
    });
  }

  void OnDone() override {
    uploads_.leave(this);
    delete this;
  }

 private:
  void read() {
    {
      const std::lock_guard lock(mutex_);
      reading_ = !late_;
      exec::before_read(chunk_);
      if (reading_) return StartRead(&chunk_);
    }
    end(slow());  // it was late while a chunk was processed
  }

  /// Whether the call was reading. The thread that ends this may end the call.
  bool stop_reading() {
    const std::lock_guard lock(mutex_);
    return std::exchange(reading_, false);
  }

  /// The wait for the peer begins again only with progress, not with every message.
  void note_progress() {
    if (upload_->committed() - progressed_to_ < kUploadProgress) return;
    progressed_to_ = upload_->committed();
    progress_.begin(kUploadTimeout);
  }

  /// The error of an upload that is too slow; it may be resumed.
  static Error slow() {
    return {Code::kAborted,
            fmt::format("the upload got fewer than {} bytes in {} s", kUploadProgress,
                        kUploadTimeout.count()),
            kTooSlow};
  }

  void end_slow() {
    {
      const std::lock_guard lock(mutex_);
      late_ = true;
      if (!std::exchange(reading_, false)) return;
    }
    end(slow());
  }

  Status accept() {
    if (chunk_.data().size() > kMaxBlobChunk) {
      return Error{
          Code::kResourceExhausted,
          fmt::format("a chunk has {} bytes, the limit is {}", chunk_.data().size(), kMaxBlobChunk),
          "CHUNK_TOO_LARGE"};
    }
    if (digest_text_.empty()) {
      if (Status begun = begin(); !begun || done_) return begun;
    } else if (!chunk_.digest().empty() && chunk_.digest() != digest_text_) {
      return Error{Code::kInvalidArgument,
                   fmt::format("a chunk of {} in the upload of {}", exec::quote(chunk_.digest()),
                               digest_text_),
                   "DIGEST_CHANGED"};
    }
    if (Status added = upload_->append(chunk_.offset(), std::as_bytes(std::span(chunk_.data())));
        !added)
      return added;
    return chunk_.finish() ? finish() : Status();
  }

  Status begin() {
    const auto digest = BlobDigest::parse(chunk_.digest());
    if (!digest) return digest.error();
    digest_text_ = chunk_.digest();
    if (blobs_.has(*digest)) {
      const auto mesh = blobs_.load(*digest);
      if (!mesh) return mesh.error();
      report(**mesh, digest->size);
      return {};
    }
    exec::Quotas::Use stored;
    if (chunk_.offset() == 0) {  // what is resumed counts already
      auto granted = parts_.quotas.store(caller_, digest->size);
      if (!granted) return granted.error();
      stored = std::move(*granted);
    }
    auto upload = blobs_.begin(*digest, chunk_.offset(), caller_, std::move(stored));
    if (!upload) return upload.error();
    upload_ = std::move(*upload);
    progressed_to_ = upload_->committed();
    return {};
  }

  Status finish() {
    const auto mesh = blobs_.complete(upload_);
    if (!mesh) return mesh.error();
    report(**mesh, upload_->digest().size);
    // The level is debug: an import logs one line for its scene, however many meshes it has.
    spdlog::debug("event=mesh_uploaded digest={} triangles={} nonfinite={}{}", digest_text_,
                  (*mesh)->triangles(), (*mesh)->nonfinite(), exec::call_ids_of(context_));
    return {};
  }

  void report(const scenegraph::model::Mesh& mesh, std::uint64_t size) {
    reply_.set_committed_size(size);
    reply_.set_triangles(mesh.triangles());
    reply_.set_triangles_nonfinite(mesh.nonfinite());
    done_ = true;
  }

  void end(const Status& status) {
    if (upload_ && !done_) {
      reply_.set_committed_size(upload_->committed());
      if (status.ok() || leaves_upload_whole(status.error())) {
        blobs_.set_aside(upload_);
      } else {
        blobs_.abandon(upload_);
      }
    }
    reply_.set_digest(digest_text_);
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("UploadBlob", context_, answer, begun_,
                  [this] { return fmt::format("digest={}", digest_text_); });
    // The call leaves before the client knows and may begin the next upload. A call that the
    // registry ends does not count any more.
    if (status.ok()) uploads_.leave(this);
    Finish(answer);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  BlobStore& blobs_;
  exec::CallRegistry& uploads_;
  const exec::UnaryParts parts_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  exec::PeerWait progress_;
  std::mutex mutex_;  // held while a read starts, and protects the next two
  bool late_ = false, reading_ = false;
  std::uint64_t progressed_to_ = 0;
  exec::Admission::Ticket ticket_;
  exec::Quotas::Use quota_;
  v1::UploadBlobResponse& reply_;
  v1::UploadBlobRequest chunk_;
  std::string digest_text_;
  std::shared_ptr<Upload> upload_;
  bool done_ = false;
};

}  // namespace

grpc::ServerUnaryReactor* BlobRpc::FindMissingBlobs(grpc::CallbackServerContext* context,
                                                    const v1::FindMissingBlobsRequest* request,
                                                    v1::FindMissingBlobsResponse* reply) {
  return answer_in_arena(
      "FindMissingBlobs", *context, *request, *reply, parts_,
      [=, this] { return find_missing(*request, blobs_, *reply); }, exec::WorkKind::kLong);
}

grpc::ServerReadReactor<v1::UploadBlobRequest>* BlobRpc::UploadBlob(
    grpc::CallbackServerContext* context, v1::UploadBlobResponse* reply) {
  auto* reactor = new UploadReactor(blobs_, uploads_, parts_, *context, *reply);
  reactor->start();
  return reactor;
}

grpc::ServerUnaryReactor* BlobRpc::GetUploadStatus(grpc::CallbackServerContext* context,
                                                   const v1::GetUploadStatusRequest* request,
                                                   v1::GetUploadStatusResponse* reply) {
  return answer_in_arena("GetUploadStatus", *context, *request, *reply, parts_,
                         [=, this] { return upload_status(*request, blobs_, *reply); });
}

}  // namespace sightline::server::blobs
