// Messages of a producer's stream: batches that arrive in parts, and the queue of answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/node.h"
#include "scenegraph/model/update.h"
#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "server/exec/quotas.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/journal.h"
#include "server/scenes/names.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

inline constexpr std::size_t kMaxBatchBytes = std::size_t{64} << 20;  ///< On the wire.

/// A numbered batch of a producer.
struct UpdateBatch {
  std::uint64_t sequence = 0;
  std::vector<scenegraph::model::Update> updates;
  std::optional<Error> bad;  ///< Why it cannot be applied. `updates` is then empty.
  std::size_t bytes = 0;     ///< On the wire.
  std::vector<exec::Admission::Ticket> tickets;  ///< Its admitted bytes.
};

/// Assembles batches from messages. Threads: one at a time.
class UpdateBatches {
 public:
  /// What a batch holds is admitted by both admissions, and by the quotas of its caller.
  UpdateBatches(blobs::BlobStore& blobs, exec::Caller caller, exec::Admission& admission,
                exec::Admission& batch_admission, exec::Quotas& quotas)
      : blobs_(blobs),
        caller_(std::move(caller)),
        admission_(admission),
        batch_admission_(batch_admission),
        quotas_(quotas) {}

  /// The next expected batch is the one after this sequence number.
  void begin(std::uint64_t last_committed) { last_ = last_committed; }

  /// What a message completes: nothing yet, the next batch, or a batch that was received before.
  enum class Received : std::uint8_t { kPart, kBatch, kRepeat };
  /// Adds a message. After kBatch, batch() returns a complete batch. Errors, which end the call:
  /// kInvalidArgument (a gap in the sequence, or an unfinished batch), kResourceExhausted (as
  /// Admission::admit and Quotas::spend). An error of the batch itself is stored in its `bad`.
  Result<Received> accept(const v1::UpdateBatch& message);
  /// Returns the complete batch and forgets it.
  UpdateBatch batch();

  /// Whether a batch is incomplete.
  bool open() const { return open_; }
  /// Bytes of the incomplete batch.
  std::size_t bytes() const { return open_ ? batch_.bytes : 0; }

 private:
  Status check_sequence(std::uint64_t sequence) const;
  Status append(const v1::UpdateBatch& message);
  Status admit(std::size_t bytes, std::size_t held);
  void refuse(Error error);

  blobs::BlobStore& blobs_;
  const exec::Caller caller_;
  exec::Admission& admission_;
  exec::Admission& batch_admission_;
  exec::Quotas& quotas_;
  std::uint64_t last_ = 0;  // sequence number of the last complete batch
  bool open_ = false;       // the last message had `more` set
  std::uint64_t open_sequence_ = 0;
  UpdateBatch batch_;
};

v1::Durability encode_durability(scenes::Durability durability);

/// The queue of answers to a producer. Consecutive acks are merged while the message stays small.
/// The queue therefore has at most twice as many answers as batches.
class UpdateAnswers {
 public:
  /// Answers the first message: the last batch committed, and the nodes that recent batches put.
  void opened(const scenes::Producer& producer, std::uint32_t window,
              const scenes::RevisionToken& revision);
  /// Applied batches; a repeated one counts as 0 batches.
  struct Applied {
    std::uint64_t sequence = 0;
    scenes::RevisionToken revision;
    std::uint64_t coalesced = 0;
    scenes::Durability durability = scenes::Durability::kRelaxed;
    std::size_t batches = 1;
  };
  /// `put`: the ids of the nodes that it put.
  void ack(const Applied& applied, const std::vector<scenegraph::model::NodeId>& put);
  void reject(std::uint64_t sequence, const Error& error);

  bool empty() const { return answers_.empty(); }
  void clear() { answers_.clear(); }
  /// Removes the oldest answer. Returns how many batches it answers.
  std::size_t pop(v1::StreamUpdatesResponse& out);

 private:
  struct Answer {
    v1::StreamUpdatesResponse message;
    std::size_t batches = 0;
    std::size_t ids = 0;
  };
  Answer& open_ack(std::size_t ids);

  std::deque<Answer> answers_;
};

}  // namespace sightline::server::updates
