// SceneService.StreamUpdates: the batches of one producer over one call.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/scenes/producers.h"
#include "server/updates/update_services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

/// Batches that a call may send beyond the last that it was told about.
inline constexpr std::uint32_t kUpdateWindow = 16;
/// Bytes of batches that wait, on the wire, unless a single one is larger.
inline constexpr std::size_t kUpdateWindowBytes = std::size_t{64} << 20;

/// The reactor of a new call, already reading; it frees itself. `services` outlive the call.
grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>* start_update_stream(
    const UpdateServices& services);

}  // namespace sightline::server::updates
