// What the threads share that expand one large cell: a chain of stages.
#pragma once

#include <cstdint>
#include <memory>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/shared_pass.h"

namespace sightline::accel::lazy {

/// How one expands a cell is a sequence of stages, each made from the results of those before. That
/// sequence is deterministic, so any thread may follow it from the start at any time and finds what
/// is done already: there is no thread that the others depend on. Threads: any.
class Expansion final : public kdtree::SharedWork {
 public:
  /// `alive` keeps what stages read of the geometry; if null, none but those who call help work
  /// here.
  explicit Expansion(std::shared_ptr<const void> alive) : alive_(std::move(alive)) {}
  ~Expansion() override;

  /// The stage behind `before` (null: the first), made from these if it is not there yet. Idle
  /// threads of the caller's arena are called to it.
  Stage& stage_after(Stage* before, std::size_t slices, Stage::Work work);

  /// Does what is to be had of the last stage. Returns whether there was anything.
  bool help(kdtree::BuildCounters& counters);

  /// Grows as work gets done.
  std::uint64_t progress() const;

  /// What called threads have counted since the last time.
  kdtree::BuildCounters take_counters();

 private:
  struct Call;
  void call_others(Stage& stage);
  Stage* last() const;

  std::shared_ptr<const void> alive_;
  std::atomic<Stage*> first_{nullptr};
  std::atomic<std::uint64_t> touches_{0}, touches_prepare_{0};
};

/// One thread's way through an expansion's stages.
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
