// Updates as messages: single requests, and the batches of a stream. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "client/calls/connection.h"
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

/// Makes the same call, send(), again if the connection breaks. Its request has an id, so that the
/// server applies it once.
template <class Send>
auto send_until_answered(const Send& send, const std::stop_token& stop = {}) {
  constexpr int kAttempts = 4;
  Backoff backoff(kAttempts);
  while (true) {
    auto answer = send();
    if (answer || !is_broken_connection(answer.error().code) || !backoff.again()) return answer;
    sleep_unless_stopped(backoff.pause(), stop);  // if stopped, the next call says so
  }
}

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options);
Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options);

}  // namespace sightline::client::calls
