// Sends a mesh to the server in chunks.
#include "client/calls/upload.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "client/calls/connection.h"
#include "client/calls/retries.h"

namespace sightline::client::calls {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr int kUploadAttempts = 4;
constexpr std::chrono::milliseconds kFirstPause{100};

Result<v1::GetUploadStatusResponse> upload_status(const Connection& connection,
                                                  const std::string& digest) {
  grpc::ClientContext context;
  set_timeout(context, connection.small_timeout());
  v1::GetUploadStatusRequest request;
  request.set_digest(digest);
  v1::GetUploadStatusResponse response;
  const grpc::Status status = connection.blobs->GetUploadStatus(&context, request, &response);
  if (!status.ok()) return rpc_error(status);
  return response;
}

// Sends all bytes from `offset` on, in one call.
grpc::Status send_from(const Connection& connection, const MeshBlob& mesh,
                       const std::string& digest, std::uint64_t offset,
                       const UploadProgress& progress, const std::stop_token& stop) {
  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
  v1::UploadBlobResponse response;
  const auto writer = connection.blobs->UploadBlob(&context, &response);
  v1::UploadBlobRequest chunk;
  chunk.set_digest(digest);
  bool open = true;
  while (open && !chunk.finish()) {
    const std::size_t n = std::min<std::uint64_t>(kChunkBytes, mesh.size() - offset);
    chunk.set_offset(offset);
    chunk.mutable_data()->resize(n);
    mesh.copy(offset, std::as_writable_bytes(std::span(*chunk.mutable_data())));
    offset += n;
    chunk.set_finish(offset == mesh.size());
    open = writer->Write(chunk);
    chunk.clear_digest();
    if (open && progress) progress(offset);
  }
  if (open) writer->WritesDone();
  return writer->Finish();
}

bool should_retry(const Error& error) {
  // The transport of a server short of memory gives up calls, without a reason.
  const bool lost_in_transport = error.code == Code::kResourceExhausted && error.reason.empty();
  // kOutOfRange: another client has added to the same upload meanwhile.
  return error.code == Code::kUnavailable || error.code == Code::kOutOfRange || lost_in_transport;
}

// Continues an earlier upload where it stopped. A mesh of one chunk is sent at once, because asking
// first would cost as much. `retries` is asked about a refusal.
Status upload_once(const Connection& connection, const MeshBlob& mesh, const std::string& digest,
                   const UploadProgress& progress, const std::stop_token& stop, Retries& retries) {
  while (true) {
    std::uint64_t begin = 0;
    if (mesh.size() > kChunkBytes) {
      const auto status = upload_status(connection, digest);
      if (!status) return status.error();
      if (status->complete()) return {};
      begin = std::min(status->committed_size(), mesh.size());
    }
    const grpc::Status sent = send_from(connection, mesh, digest, begin, progress, stop);
    if (sent.ok()) return {};
    if (!retries.wait(sent, stop)) return rpc_error(sent, stop);
  }
}

}  // namespace

Status upload_mesh(const Connection& connection, const MeshBlob& mesh, const std::string& digest,
                   const UploadProgress& progress, const std::stop_token& stop) {
  auto pause = kFirstPause;
  Retries retries;
  for (int attempt = 1;; ++attempt, pause *= 2) {
    Status uploaded = upload_once(connection, mesh, digest, progress, stop, retries);
    if (uploaded || attempt == kUploadAttempts || !should_retry(uploaded.error())) return uploaded;
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace sightline::client::calls
