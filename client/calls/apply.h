// Updates as messages: single requests, and the batches of a stream. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/calls/unary_call.h"
#include "client/result.h"
#include "client/update.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

inline constexpr std::size_t kMaxUpdatesPerBatch = 65536;
inline constexpr std::size_t kMaxBatchBytes = std::size_t{64} << 20;

/// Packs updates into the messages of one batch. All but the last message have `more` set, and each
/// stays below the limit of a message. Their sequence number is not set. Errors: kInvalidArgument
/// as of check(); kResourceExhausted if the batch is beyond the limits above, or if a single update
/// (one with many nodes, for example) fits no message.
Result<std::vector<v1::StreamUpdatesRequest>> pack_batch(std::span<const Update> updates);

void set_sequence(std::uint64_t sequence, std::vector<v1::StreamUpdatesRequest>& messages);

/// A request for one message of updates, with an id and without a scene. Errors: kInvalidArgument,
/// as of check(); kResourceExhausted if the updates do not fit one message.
Result<v1::ApplyUpdatesRequest> encode_batch(std::span<const Update> updates,
                                             const ApplyOptions& options);
Applied decode(const v1::ApplyUpdatesResponse& response);

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options);
/// As apply(), begun later. Copies `updates`.
Begin<Applied> async_apply(const std::shared_ptr<const Connection>& connection,
                           const std::string& scene, std::span<const Update> updates,
                           const ApplyOptions& options);
Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options);

}  // namespace sightline::client::calls
