// Applies the batches of one producer, on the scene's write queue.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "accel/result.h"
#include "scenegraph/scene.h"
#include "server/exec/executors.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/stored_scene.h"
#include "server/updates/producer_messages.h"

namespace sightline::server::updates {

/// The result of a batch.
struct BatchOutcome {
  std::uint64_t sequence = 0;
  std::size_t bytes = 0;  ///< On the wire.
  Result<scenegraph::Applied> applied;
};

/// Used only by tasks of the scene's write queue.
class ProducerSession {
 public:
  struct Call {
    const void* id = nullptr;
    const std::atomic<bool>* cancelled = nullptr;  ///< Null: never.
    bool latest_wins = false;
  };

  /// `producer` belongs to `scene`. All arguments, and what `call` points to, outlive this object.
  ProducerSession(scenes::StoredScene& scene, scenes::Producer& producer, const Call& call,
                  exec::Compute& compute)
      : scene_(scene), producer_(producer), call_(call), compute_(compute) {}

  /// Makes the call the owner of the producer and notifies the previous owner.
  void take_over();
  /// Gives the producer up if the call still owns it.
  void leave();

  /// Applies the first batch, or several first batches as one, and removes them from `batches`.
  /// Returns an outcome for each. Errors end the call and leave all batches unapplied: kNotFound
  /// (the scene is removed), kAborted (another call has taken over), kResourceExhausted (no
  /// memory), kCancelled.
  Result<std::vector<BatchOutcome>> apply_some(std::deque<UpdateBatch>& batches);

  /// Batches that were merged with newer ones.
  std::uint64_t coalesced() const { return coalesced_; }

 private:
  scenegraph::ApplyOptions options(std::function<void(const scenegraph::Applied&)> record) const;
  bool apply_together(std::deque<UpdateBatch>& batches, std::vector<BatchOutcome>& outcomes);
  Status apply_first(std::deque<UpdateBatch>& batches, std::vector<BatchOutcome>& outcomes);
  using Puts = std::vector<scenes::Producer::Put>;
  Puts prepare(const std::deque<UpdateBatch>& batches, std::size_t count,
               const Result<scenegraph::Applied>& result, std::vector<BatchOutcome>& outcomes);
  void commit(std::deque<UpdateBatch>& batches, Puts puts) noexcept;

  scenes::StoredScene& scene_;
  scenes::Producer& producer_;
  const Call call_;
  exec::Compute& compute_;
  std::size_t alone_ = 0;  // first batches that must be applied one by one
  std::uint64_t coalesced_ = 0;
};

/// kAborted: the error of a call whose producer a newer call has opened.
Error taken_over();

}  // namespace sightline::server::updates
