// Assembles the batches of one producer from messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

inline constexpr std::size_t kMaxBatchBytes = std::size_t{64} << 20;  ///< On the wire.

struct UpdateBatch {
  std::uint64_t sequence = 0;
  std::vector<scenegraph::model::Update> updates;
  std::optional<Error> bad;  ///< Why it cannot be applied. `updates` is then empty.
  std::size_t bytes = 0;     ///< On the wire.
  std::vector<exec::Admission::Ticket> tickets;  ///< Its admitted bytes.
};

/// Threads: one at a time.
class UpdateBatches {
 public:
  UpdateBatches(const blobs::BlobStore& blobs, exec::Admission& admission)
      : blobs_(blobs), admission_(admission) {}

  /// The next expected batch is the one after this sequence number.
  void begin(std::uint64_t last_committed) { last_ = last_committed; }

  enum class Received : std::uint8_t { kPart, kBatch, kRepeat };
  /// Adds a message. After kBatch, batch() returns a complete batch. Errors, which end the call:
  /// kInvalidArgument (a gap in the sequence, or an unfinished batch), kResourceExhausted (as
  /// Admission::admit). An error of the batch itself is stored in its `bad`.
  Result<Received> accept(const v1::UpdateBatch& message);
  UpdateBatch batch();

  /// Bytes of the incomplete batch.
  std::size_t bytes() const { return open_ ? batch_.bytes : 0; }

 private:
  Status check_sequence(std::uint64_t sequence) const;
  Status append(const v1::UpdateBatch& message);
  void refuse(Error error);

  const blobs::BlobStore& blobs_;
  exec::Admission& admission_;
  std::uint64_t last_ = 0;  // sequence number of the last complete batch
  bool open_ = false;       // the last message had `more` set
  std::uint64_t open_sequence_ = 0;
  UpdateBatch batch_;
};

}  // namespace sightline::server::updates
