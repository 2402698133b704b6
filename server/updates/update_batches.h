// The batches of one producer as they come in, each in one message or several.
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
  std::optional<Error> bad;  ///< Why it cannot be applied; then there are no updates.
  std::size_t bytes = 0;     ///< On the wire.
  std::vector<exec::Admission::Ticket> tickets;  ///< Its place among the bytes in work.
};

/// One thread at a time.
class UpdateBatches {
 public:
  UpdateBatches(const blobs::BlobStore& blobs, exec::Admission& admission)
      : blobs_(blobs), admission_(admission) {}

  /// Batches are expected from the one after this sequence on.
  void begin(std::uint64_t last_committed) { last_ = last_committed; }

  enum class Received : std::uint8_t { kPart, kBatch, kRepeat };
  /// A message. After kBatch, batch() is whole. Errors, which end the call: kInvalidArgument (a gap
  /// in the sequence, or a batch that is not finished), kResourceExhausted (as Admission::admit).
  /// What is wrong with a batch itself is in its `bad`.
  Result<Received> accept(const v1::UpdateBatch& message);
  UpdateBatch batch();

  /// Of the batch that is not whole yet.
  std::size_t bytes() const { return open_ ? batch_.bytes : 0; }

 private:
  Status check_sequence(std::uint64_t sequence) const;
  Status append(const v1::UpdateBatch& message);
  void refuse(Error error);

  const blobs::BlobStore& blobs_;
  exec::Admission& admission_;
  std::uint64_t last_ = 0;  // sequence that came whole
  bool open_ = false;       // a message with `more` was the last
  std::uint64_t open_sequence_ = 0;
  UpdateBatch batch_;
};

}  // namespace sightline::server::updates
