// What the threads share that expand one large cell: a chain of passes.
#pragma once

#include <cstdint>
#include <memory>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/shared_pass.h"

namespace sightline::accel::lazy {

/// How one expands a cell is a sequence of passes, each made from the results of those before. That
/// sequence is deterministic, so any thread may follow it from the start at any time and finds what
/// is done already: there is no thread that the others depend on. Threads: any.
class CellTask final : public kdtree::SharedWork {
 public:
  /// `alive` keeps what passes read of the geometry; if null, none but those who call help work
  /// here.
  explicit CellTask(std::shared_ptr<const void> alive) : alive_(std::move(alive)) {}
  ~CellTask() override;

  /// The pass behind `before` (null: the first), made from these if it is not there yet. Idle
  /// threads of the caller's arena are called to it.
  SharedPass& pass_after(SharedPass* before, std::size_t slices, SharedPass::Work work);

  /// Does what is to be had of the last pass. Returns whether there was anything.
  bool help(kdtree::BuildCounters& counters);

  /// Grows as work gets done.
  std::uint64_t progress() const;

  /// What called threads have counted since the last time.
  kdtree::BuildCounters take_counters();

 private:
  struct Call;
  void call_others(SharedPass& pass);
  SharedPass* last() const;

  std::shared_ptr<const void> alive_;
  std::atomic<SharedPass*> first_{nullptr};
  std::atomic<std::uint64_t> touches_{0}, touches_prepare_{0};
};

/// One thread's way through an expansion's passes.
class PassSequence {
 public:
  PassSequence(CellTask& task, kdtree::BuildCounters& counters)
      : task_(task), counters_(counters) {}

  /// The next pass, done: by us, by others while we wait, or by us after all if those have
  /// stopped. Throws std::bad_alloc.
  const SharedPass& next(std::size_t slices, SharedPass::Work work);

 private:
  CellTask& task_;
  kdtree::BuildCounters& counters_;
  SharedPass* at_ = nullptr;
};

}  // namespace sightline::accel::lazy
