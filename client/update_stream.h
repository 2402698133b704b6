// Many batches of updates over one call, each applied once, through broken connections.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/result.h"
#include "client/update.h"

namespace sightline::client::calls {
class UpdateStreamWorker;
}

namespace sightline::client {

/// All batches up to a sequence number are answered: applied, or rejected.
struct StreamAck {
  struct Put {
    std::uint64_t sequence = 0;
    std::vector<std::uint64_t> nodes;  ///< The id of every PutNode's node of that batch, in order.
  };
  std::uint64_t up_to_sequence = 0;
  std::uint64_t revision = 0;  ///< Holds them all.
  std::string token;           ///< Of the revision, for Consistency::at_least.
  std::vector<Put> put;        ///< Of batches answered since the ack before.
};

/// One batch did nothing, and all before it are answered; the stream goes on.
struct StreamReject {
  std::uint64_t sequence = 0;
  Error error;
};

struct UpdateStreamOptions {
  /// Batches that wait at the server may be made one: of each node, the newest transform and the
  /// newest vertices count. A batch that holds anything else is applied as it is.
  bool latest_wins = false;
  /// How many times in a row the call is opened before a broken connection is an error.
  int attempts = 8;
  /// Called in the order of answers, on a thread of the stream that goes on only when they return.
  /// They must not call send, wait, flush or close, nor destroy the stream.
  std::function<void(const StreamAck&)> on_ack{};
  std::function<void(const StreamReject&)> on_reject{};
};

struct UpdateStreamState {
  std::uint64_t last_sent = 0;      ///< Sequence numbers; those of earlier streams of the same
  std::uint64_t last_answered = 0;  ///< producer count on.
  std::uint64_t revision = 0;       ///< Holds all that is answered.
  std::string token;
  std::uint32_t window = 0;     ///< How many batches may be on their way.
  std::uint64_t coalesced = 0;  ///< Batches that newer ones were put in place of.
  std::uint64_t rejected = 0;
  std::uint64_t reconnects = 0;
  std::uint64_t bytes_sent = 0;  ///< Messages, those sent again included.
};

/// A producer's stream, made by Client::open_update_stream. It keeps what is not answered; when the
/// connection breaks it opens again, with growing pauses, and sends what the server has not
/// committed: every batch is applied once. Whether one was rejected is not told if that answer was
/// lost with the connection.
///
/// Once it has failed, every call returns that error, but for wait() on what was answered before:
/// kAborted if another stream of the same producer was opened, or the scene is not the one that it
/// was; kNotFound if the scene is gone; kUnavailable if the server stayed away. Threads: any; what
/// several send at a time goes in any order. May outlive its Client.
class UpdateStream {
 public:
  UpdateStream(UpdateStream&&) noexcept;
  UpdateStream& operator=(UpdateStream&&) noexcept;
  /// What is not answered may be applied or not. See close.
  ~UpdateStream();

  /// Hands a batch over, which is one revision, all of it or none, and returns its number, 1 more
  /// than that of the one before. Waits while the window is full. Aliases hold within the batch.
  /// Errors: kInvalidArgument, transforms without nodes; kResourceExhausted, more than 65,536
  /// updates or 64 MiB.
  Result<std::uint64_t> send(std::span<const Update> updates);
  /// The same, but where it would have to wait it does nothing and returns nothing.
  Result<std::optional<std::uint64_t>> try_send(std::span<const Update> updates);

  /// Waits until the batch is answered. Errors: its own, if it was rejected (the last 1,024 rejects
  /// are known).
  Status wait(std::uint64_t sequence);
  /// Waits until all that was sent is answered. Rejects are no error here.
  Status flush();
  /// Flushes, and ends the stream. Sending is an error from then on.
  Status close();

  UpdateStreamState state() const;

 private:
  friend class Client;
  explicit UpdateStream(std::unique_ptr<calls::UpdateStreamWorker> worker);
  std::unique_ptr<calls::UpdateStreamWorker> worker_;
};

}  // namespace sightline::client
