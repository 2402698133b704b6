// A stream of batches of updates. Each batch is applied once, even if connections break.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "client/result.h"
#include "client/update.h"

namespace sightline::client::calls {
class UpdateStreamWorker;
}

namespace sightline::client {

/// A producer's stream, made by Client::open_update_stream. It keeps all batches that are not
/// answered. When the connection breaks, it opens the call again, with growing pauses, and sends
/// the batches that the server has not committed, so every batch is applied once. If the answer
/// that rejects a batch is lost with the connection, the reject is not reported.
///
/// After a failure every call returns that error, except wait() on a batch that was answered
/// before. Errors: kAborted if another stream of the same producer was opened, or the scene was
/// replaced; kNotFound if the scene was deleted; kUnavailable if the server could not be reached.
/// Threads: any; batches that several threads send at the same time are sent in any order. May
/// outlive its Client.
class UpdateStream {
 public:
  UpdateStream(UpdateStream&&) noexcept;
  UpdateStream& operator=(UpdateStream&&) noexcept;
  /// Batches that are not answered may or may not be applied. See close.
  ~UpdateStream();

  /// Sends a batch, which makes one revision as a whole or none, and returns its sequence number, 1
  /// more than that of the batch before. Waits while the window is full. Aliases hold within the
  /// batch. Errors: kInvalidArgument, the numbers of nodes and transforms differ;
  /// kResourceExhausted, the batch is larger than the server's limits (65,536 updates, 64 MiB).
  Result<std::uint64_t> send(std::span<const Update> updates);
  /// Sends a batch as send() does. Does nothing and returns nothing if it would have to wait.
  Result<std::optional<std::uint64_t>> try_send(std::span<const Update> updates);

  /// Waits until the batch is answered. Errors: the reason if the batch was rejected (the last
  /// 1,024 rejects are kept).
  Status wait(std::uint64_t sequence);
  /// Waits until all that was sent is answered. A reject is no error here.
  Status flush();
  /// Flushes and ends the stream. Sending afterwards is an error.
  Status close();

  UpdateStreamState state() const;

 private:
  friend class Client;
  explicit UpdateStream(std::unique_ptr<calls::UpdateStreamWorker> worker);
  std::unique_ptr<calls::UpdateStreamWorker> worker_;
};

}  // namespace sightline::client
