// BlobService.UploadBlob: the chunks of one mesh, in order.
#pragma once

#include <cstddef>

#include "server/blobs/blob_store.h"
#include "server/exec/compute.h"
#include "server/scenes/scene_store.h"
#include "sightline/v1/blob.grpc.pb.h"

namespace sightline::server::blobs {

inline constexpr std::size_t kMaxBlobChunk = std::size_t{1} << 20;  ///< Bytes of data in a message.

/// The reactor of a new call, already reading; it frees itself. All arguments outlive the call.
grpc::ServerReadReactor<v1::UploadBlobRequest>* start_upload(scenes::SceneStore& scenes,
                                                             BlobStore& blobs,
                                                             exec::Compute& compute,
                                                             v1::UploadBlobResponse& reply);

}  // namespace sightline::server::blobs
