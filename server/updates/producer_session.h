// Applies the batches of one producer in the scene's turn.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "accel/result.h"
#include "scenegraph/scene.h"
#include "server/exec/compute.h"
#include "server/scenes/producers.h"
#include "server/scenes/stored_scene.h"
#include "server/updates/update_batches.h"

namespace sightline::server::updates {

/// What became of a batch.
struct BatchOutcome {
  std::uint64_t sequence = 0;
  std::size_t bytes = 0;  ///< Of the batch.
  Result<scenegraph::Applied> applied;
};

/// To be used in the scene's turn alone.
class ProducerSession {
 public:
  /// `producer` is of `scene`. Both, and `call`, outlive this.
  ProducerSession(scenes::StoredScene& scene, scenes::Producer& producer, const void* call,
                  exec::Compute& compute, bool latest_wins)
      : scene_(scene),
        producer_(producer),
        call_(call),
        compute_(compute),
        latest_wins_(latest_wins) {}

  /// Makes `call` the one that speaks for the producer; the one before is told.
  void take_over();
  /// As a call ends.
  void leave();

  /// Applies the first batch, or several as one; an outcome for each that is taken. Errors, which
  /// end the call and leave all batches undone: kNotFound (the scene is removed), kAborted (another
  /// call has taken over), kResourceExhausted (no memory).
  Result<std::vector<BatchOutcome>> apply_some(std::deque<UpdateBatch>& batches);

  /// Batches that were made one with newer ones.
  std::uint64_t coalesced() const { return coalesced_; }

 private:
  bool apply_together(std::deque<UpdateBatch>& batches, std::vector<BatchOutcome>& outcomes);
  Status apply_first(std::deque<UpdateBatch>& batches, std::vector<BatchOutcome>& outcomes);
  void commit(std::deque<UpdateBatch>& batches, Result<scenegraph::Applied> applied,
              std::vector<BatchOutcome>& outcomes);

  scenes::StoredScene& scene_;
  scenes::Producer& producer_;
  const void* const call_;
  exec::Compute& compute_;
  const bool latest_wins_;
  std::size_t alone_ = 0;  // first batches that cannot be made one
  std::uint64_t coalesced_ = 0;
};

/// What a call is told whose producer was opened by a newer one.
Error taken_over();

}  // namespace sightline::server::updates
