// BlobService: which meshes the server has, and uploads of them.
#pragma once

#include <chrono>
#include <cstddef>

#include "server/blobs/blob_store.h"
#include "server/exec/call_registry.h"
#include "server/exec/unary_rpc.h"
#include "sightline/v1/blob.grpc.pb.h"

namespace sightline::server::blobs {

inline constexpr int kMaxDigestsPerRequest = 8192;
inline constexpr std::size_t kMaxBlobChunk = std::size_t{1} << 20;  ///< Bytes of data in a message.

/// UploadBlob calls open on the whole server.
inline constexpr std::size_t kMaxUploadCalls = 128;
/// An upload makes progress (kUploadProgress) at least this often, or its call is ended.
inline constexpr std::chrono::seconds kUploadTimeout{60};

class BlobRpc : public v1::BlobService::CallbackService {
 public:
  /// Calls that upload are registered in `uploads`. All arguments outlive every call.
  BlobRpc(BlobStore& blobs, exec::CallRegistry& uploads, const exec::UnaryParts& parts)
      : blobs_(blobs), uploads_(uploads), parts_(parts) {}

  grpc::ServerUnaryReactor* FindMissingBlobs(grpc::CallbackServerContext* context,
                                             const v1::FindMissingBlobsRequest* request,
                                             v1::FindMissingBlobsResponse* reply) override;
  grpc::ServerReadReactor<v1::UploadBlobRequest>* UploadBlob(
      grpc::CallbackServerContext* context, v1::UploadBlobResponse* reply) override;
  grpc::ServerUnaryReactor* GetUploadStatus(grpc::CallbackServerContext* context,
                                            const v1::GetUploadStatusRequest* request,
                                            v1::GetUploadStatusResponse* reply) override;

 private:
  BlobStore& blobs_;
  exec::CallRegistry& uploads_;
  const exec::UnaryParts parts_;
};

}  // namespace sightline::server::blobs
