// BlobService: which meshes the server has, and uploads of them.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "server/exec/executors.h"
#include "sightline/v1/blob.grpc.pb.h"

namespace sightline::server::blobs {

inline constexpr int kMaxDigestsPerRequest = 8192;
inline constexpr std::size_t kMaxBlobChunk = std::size_t{1} << 20;  ///< Bytes of data in a message.

class BlobRpc final : public v1::BlobService::CallbackService {
 public:
  /// release_meshes() drops the references to meshes that only old revisions use. It is called when
  /// the memory budget is used up, on a worker. All arguments outlive every call.
  BlobRpc(BlobStore& blobs, exec::Compute& compute, exec::Admission& admission,
          std::function<void()> release_meshes)
      : blobs_(blobs),
        compute_(compute),
        admission_(admission),
        release_meshes_(std::move(release_meshes)) {}

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
  exec::Compute& compute_;
  exec::Admission& admission_;
  const std::function<void()> release_meshes_;
};

}  // namespace sightline::server::blobs
