// The work that threads share to expand one large cell: a chain of passes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/shared_pass.h"

namespace sightline::accel::lazy {

/// A cell is expanded by a sequence of passes, each made from the results of those before. The
/// sequence is deterministic, so any thread can follow it from the start at any time and finds the
/// passes that are done: no thread depends on another one. Threads: any.
class CellTask final : public kdtree::RefCounted {
 public:
  /// `alive` keeps the geometry alive that passes read; if null, only threads that call help() work
  /// here.
  explicit CellTask(std::shared_ptr<const void> alive) : alive_(std::move(alive)) {}
  ~CellTask() override;

  /// The pass after `before` (null: the first); made from `slices` and `work` if there is none yet.
  /// Then idle threads of the caller's arena are called to help.
  SharedPass& pass_after(SharedPass* before, std::size_t slices, SharedPass::Work work);

  /// Does slices of the last pass that no thread has begun, until `cancelled`. Returns whether
  /// there were any.
  bool help(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

  /// While one lives, a query wants the cell. Called threads stop when none does.
  class Wanted {
   public:
    explicit Wanted(CellTask& task) : task_(task), first_(task_.wanted_.fetch_add(1) == 0) {}
    ~Wanted() { task_.wanted_.fetch_sub(1); }
    Wanted(const Wanted&) = delete;
    Wanted& operator=(const Wanted&) = delete;

    /// Whether none lived before it.
    bool is_first() const { return first_; }

   private:
    CellTask& task_;
    const bool first_;
  };

  /// Whether a query wants the cell now.
  bool is_wanted() const { return wanted_.load(std::memory_order_relaxed) > 0; }

  /// Increases whenever a slice is done.
  std::uint64_t progress() const;

  /// Work counted by called threads since the last call.
  kdtree::BuildCounters take_counters();

 private:
  struct Call;
  void call_others(SharedPass& pass);
  SharedPass* last() const;

  std::shared_ptr<const void> alive_;
  std::atomic<SharedPass*> first_{nullptr};
  std::atomic<std::uint64_t> touches_{0}, touches_prepare_{0};
  std::atomic<int> wanted_{0};
};

/// One thread's position in the chain of passes.
class PassSequence {
 public:
  PassSequence(CellTask& task, kdtree::BuildCounters& counters,
               const std::atomic<bool>* cancelled = nullptr)
      : task_(task), counters_(counters), cancelled_(cancelled) {}

  /// The next pass, complete. This thread does slices, waits for other threads' slices, and does
  /// those, too, if the others have stopped. Throws std::bad_alloc, and Cancelled.
  const SharedPass& next(std::size_t slices, SharedPass::Work work);

 private:
  CellTask& task_;
  kdtree::BuildCounters& counters_;
  const std::atomic<bool>* cancelled_;
  SharedPass* at_ = nullptr;
};

}  // namespace sightline::accel::lazy
