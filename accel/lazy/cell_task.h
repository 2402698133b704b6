// The chain of stages that threads share when they expand one large cell.
#pragma once

#include <cstdint>
#include <memory>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/shared_pass.h"

namespace sightline::accel::lazy {

/// A cell is expanded by a sequence of stages, each made from the results of the earlier ones. The
/// sequence is deterministic, so any thread may follow it from the start at any time and finds the
/// finished stages: no thread depends on another. Threads: any.
class Expansion final : public kdtree::SharedWork {
 public:
  /// `alive` keeps the geometry that stages read; if null, only threads that call help() work here
  /// and idle threads are not called.
  explicit Expansion(std::shared_ptr<const void> alive) : alive_(std::move(alive)) {}
  ~Expansion() override;

  /// The stage after `before` (null: the first). It is made from these arguments if it does not
  /// exist yet; then idle threads of the caller's arena are called to it.
  Stage& stage_after(Stage* before, std::size_t slices, Stage::Work work);

  /// Makes slices of the last stage that no thread has begun. Returns whether there were any.
  bool help(kdtree::BuildCounters& counters);

  /// Grows with every stage and every slice that is done.
  std::uint64_t progress() const;

  /// The work that called threads have counted since the last call.
  kdtree::BuildCounters take_counters();

 private:
  struct Call;
  void call_others(Stage& stage);
  Stage* last() const;

  std::shared_ptr<const void> alive_;
  std::atomic<Stage*> first_{nullptr};
  std::atomic<std::uint64_t> touches_{0}, touches_prepare_{0};
};

/// Follows the stages of an expansion, for one thread.
class Replay {
 public:
  Replay(Expansion& expansion, kdtree::BuildCounters& counters)
      : expansion_(expansion), counters_(counters) {}

  /// The next stage, all its slices done (Stage::complete). Throws std::bad_alloc.
  const Stage& next(std::size_t slices, Stage::Work work);

 private:
  Expansion& expansion_;
  kdtree::BuildCounters& counters_;
  Stage* at_ = nullptr;
};

}  // namespace sightline::accel::lazy
