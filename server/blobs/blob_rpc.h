// BlobService.
#pragma once

#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "server/exec/compute.h"
#include "server/scenes/scene_store.h"
#include "sightline/v1/blob.grpc.pb.h"

namespace sightline::server::blobs {

inline constexpr int kMaxDigestsPerRequest = 8192;

class BlobRpc final : public v1::BlobService::CallbackService {
 public:
  /// All outlive every call.
  BlobRpc(scenes::SceneStore& scenes, BlobStore& blobs, exec::Compute& compute,
          exec::Admission& admission)
      : scenes_(scenes), blobs_(blobs), compute_(compute), admission_(admission) {}

  grpc::ServerUnaryReactor* FindMissingBlobs(grpc::CallbackServerContext* context,
                                             const v1::FindMissingBlobsRequest* request,
                                             v1::FindMissingBlobsResponse* reply) override;
  grpc::ServerReadReactor<v1::UploadBlobRequest>* UploadBlob(
      grpc::CallbackServerContext* context, v1::UploadBlobResponse* reply) override;
  grpc::ServerUnaryReactor* GetUploadStatus(grpc::CallbackServerContext* context,
                                            const v1::GetUploadStatusRequest* request,
                                            v1::GetUploadStatusResponse* reply) override;

 private:
  scenes::SceneStore& scenes_;
  BlobStore& blobs_;
  exec::Compute& compute_;
  exec::Admission& admission_;
};

}  // namespace sightline::server::blobs
