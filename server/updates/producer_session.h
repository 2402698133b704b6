// Applies the batches of one producer, on the scene's write queue.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "proto/result.h"
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

/// Batches that are kept as one, or a rejected one.
struct Answered {
  std::vector<BatchOutcome> outcomes;
  scenes::Durability durability = scenes::Durability::kRelaxed;
};

/// Used only by tasks of the scene's write queue.
class ProducerSession {
 public:
  struct Call {
    const void* id = nullptr;
    const std::atomic<bool>* cancelled = nullptr;  ///< Null: never.
    bool latest_wins = false;
    bool relaxed = false;  ///< Acknowledges batches before they are on disk.
    /// Called on the write queue for every batch that apply_some() has taken, in order. An error
    /// ends the call: these batches and all that follow had no effect.
    std::function<void(const Result<Answered>&)> answer;
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
  /// They are answered once they are kept, perhaps before this returns. Errors end the call and
  /// leave all batches unapplied: kNotFound (the scene is removed), kAborted (another call has
  /// taken over), kResourceExhausted (no memory), kUnavailable (the store fails), kCancelled.
  Status apply_some(std::deque<UpdateBatch>& batches);

  /// Whether apply_some() has left a batch that is invalid here and may be valid where more is
  /// known: call apply_some() again after caught_up().
  bool awaits_others() const { return awaits_others_; }
  /// All that other servers had committed is published.
  void caught_up() {
    awaits_others_ = false;
    caught_up_ = true;
  }

  /// Batches that were merged with newer ones.
  std::uint64_t coalesced() const { return coalesced_; }

 private:
  using Taken = std::shared_ptr<Answered>;
  scenegraph::ApplyOptions options(const Taken& taken) const;
  scenes::SceneWrite write(const Taken& taken) const;
  bool apply_together(std::deque<UpdateBatch>& batches);
  Status apply_first(std::deque<UpdateBatch>& batches);

  scenes::StoredScene& scene_;
  scenes::Producer& producer_;
  const Call call_;
  exec::Compute& compute_;
  std::size_t alone_ = 0;  // first batches that must be applied one by one
  std::uint64_t coalesced_ = 0;
  bool awaits_others_ = false;
  bool caught_up_ = false;  // for the first batch
};

/// kAborted: the error of a call whose producer a newer call has opened.
Error taken_over();

}  // namespace sightline::server::updates
