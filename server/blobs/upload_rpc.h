// BlobService.UploadBlob: the chunks of one mesh, in order.
#pragma once

#include <cstddef>
#include <functional>

#include "server/blobs/blob_store.h"
#include "server/exec/executors.h"
#include "sightline/v1/blob.grpc.pb.h"

namespace sightline::server::blobs {

inline constexpr std::size_t kMaxBlobChunk = std::size_t{1} << 20;  ///< Bytes of data in a message.

/// The reactor of a new call, which already reads; it deletes itself. release_meshes() is called
/// when the memory budget is used up. All arguments outlive the call.
grpc::ServerReadReactor<v1::UploadBlobRequest>* start_upload(
    BlobStore& blobs, exec::Compute& compute, const std::function<void()>& release_meshes,
    v1::UploadBlobResponse& reply);

}  // namespace sightline::server::blobs
