// SceneService.StreamUpdates: the batches of one producer over one call.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "server/scenes/idempotency.h"
#include "server/scenes/services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

/// Open StreamUpdates calls on the whole server.
inline constexpr std::size_t kMaxUpdateStreams = 256;
/// A batch of which a part has arrived must go on within this time.
inline constexpr std::chrono::seconds kBatchTimeout{20};
/// Batches that a client may send after the last batch whose answer it has received.
inline constexpr std::uint32_t kUpdateWindow = 16;
/// Bytes of waiting batches, as encoded on the wire. A single larger batch is allowed.
inline constexpr std::size_t kUpdateWindowBytes = std::size_t{64} << 20;

/// The reactor of a new call, which already reads; it deletes itself. The arguments outlive
/// the call.
grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>* start_update_stream(
    const scenes::Services& services, grpc::CallbackServerContext& context);

}  // namespace sightline::server::updates
