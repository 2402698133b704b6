// BlobService.
#include "server/blobs/blob_rpc.h"

#include <fmt/format.h>

#include "server/blobs/upload_rpc.h"
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
  for (const std::string& text : request.digests()) {
    const auto digest = BlobDigest::parse(text);
    if (!digest) return digest.error();
    if (blobs.find(*digest) == nullptr) reply.add_digests(text);
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

}  // namespace

grpc::ServerUnaryReactor* BlobRpc::FindMissingBlobs(grpc::CallbackServerContext* context,
                                                    const v1::FindMissingBlobsRequest* request,
                                                    v1::FindMissingBlobsResponse* reply) {
  return answer_in_arena("FindMissingBlobs", *context, *request, compute_, admission_,
                         [=, this] { return find_missing(*request, blobs_, *reply); });
}

grpc::ServerReadReactor<v1::UploadBlobRequest>* BlobRpc::UploadBlob(grpc::CallbackServerContext*,
                                                                    v1::UploadBlobResponse* reply) {
  return start_upload(blobs_, compute_, release_meshes_, *reply);
}

grpc::ServerUnaryReactor* BlobRpc::GetUploadStatus(grpc::CallbackServerContext* context,
                                                   const v1::GetUploadStatusRequest* request,
                                                   v1::GetUploadStatusResponse* reply) {
  return answer_in_arena("GetUploadStatus", *context, *request, compute_, admission_,
                         [=, this] { return upload_status(*request, blobs_, *reply); });
}

}  // namespace sightline::server::blobs
