// The passes over the references of a cell, which threads that expand it share.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/cancelled.h"
#include "accel/lazy/shared_slices.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::lazy {

class SplitTree;  // split_tree.h

/// What a slice adds to the list of one new cell.
struct ListPart {
  kdtree::ReferenceList list;
  kdtree::ChildScan first{};  ///< The counts of the first pass over the list, if they were made.
  bool openable = false;      ///< Whether references of the list may be openable.
  geometry::Aabb bounds{};    ///< Of the list, if it was sifted.
};

/// References on both sides of a plane, before clipping.
struct Straddling {
  std::size_t openable = 0, all = 0;
};

/// The result of one slice. Each kind of pass sets its members.
struct PassSlice {
  std::optional<split::PassResult> sums{};  ///< Scanning.
  std::optional<kdtree::Split> cut{};  ///< Choosing, for rules that need the list in one piece.
  std::shared_ptr<const SplitTree> cuts{};  ///< Choosing by a sample.
  std::vector<ListPart> parts{};  ///< Sifting: one for each new cell. Opening and listing: one.
  Straddling straddling{};        ///< Sifting by one plane.
};

/// One pass. Slices are pure functions of the cell, so several threads may do the same slice: the
/// first result is kept. Threads: any.
struct SharedPass {
  /// Does one slice. Owns all that it reads. Adds its work to the counters.
  using Work = std::function<PassSlice(std::size_t slice, kdtree::BuildCounters&)>;

  SharedPass(std::size_t slices, Work does) : work(std::move(does)), results(slices) {}

  /// What makes a slice for SharedSlices. It throws std::bad_alloc, and Cancelled if stop() is
  /// true.
  template <class Stop>
  auto maker(kdtree::BuildCounters& counters, const Stop& stop) const {
    return [this, &counters, stop](std::size_t slice) {
      if (stop()) throw Cancelled();
      return std::make_unique<const PassSlice>(work(slice, counters));
    };
  }

  const Work work;
  SharedSlices<PassSlice> results;
  std::atomic<SharedPass*> next{nullptr};  ///< Null: there is none yet.
};

/// The passes over a large cell, each made from the results of those before. They are the same for
/// every thread, so any thread can follow them from the start at any time and finds those that are
/// done: no thread depends on another one. Threads: any.
class PassChain final : public kdtree::RefCounted {
 public:
  /// `alive` keeps the geometry alive that passes read; if null, only threads that call help() work
  /// here.
  explicit PassChain(std::shared_ptr<const void> alive) : alive_(std::move(alive)) {}
  ~PassChain() override;

  /// The pass after `before` (null: the first); made from `slices` and `work` if there is none yet.
  /// Then idle threads of the caller's arena are called to help.
  SharedPass& pass_after(SharedPass* before, std::size_t slices, SharedPass::Work work);

  /// Does slices of the last pass that no thread has begun, until `cancelled`. Returns whether
  /// there were any.
  bool help(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

  /// While one lives, a query wants the cell. Called threads stop when none does.
  class Wanted {
   public:
    explicit Wanted(PassChain& chain) : chain_(chain), first_(chain.wanted_.fetch_add(1) == 0) {}
    ~Wanted() { chain_.wanted_.fetch_sub(1); }
    Wanted(const Wanted&) = delete;
    Wanted& operator=(const Wanted&) = delete;

    /// Whether none lived before it.
    bool is_first() const { return first_; }

   private:
    PassChain& chain_;
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

  std::shared_ptr<const void> alive_;
  std::atomic<SharedPass*> first_{nullptr};
  std::atomic<std::uint64_t> touches_{0}, touches_prepare_{0};
  std::atomic<int> wanted_{0};
};

/// One thread's way through the passes over a cell. Threads: one.
class Passes {
 public:
  /// Of a cell that no other thread divides: each pass is done at once.
  explicit Passes(kdtree::BuildCounters& counters) : counters_(counters) {}
  Passes(PassChain& chain, kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled)
      : chain_(&chain), counters_(counters), cancelled_(cancelled) {}

  kdtree::BuildCounters& counters() const { return counters_; }

  /// The next pass: calls take() with what work(slice, counters) returns for each slice, in order.
  /// This thread does slices, waits for other threads' slices, and does those, too, if the others
  /// have stopped. Throws std::bad_alloc, and Cancelled.
  template <class Work, class Take>
  void run(std::size_t slices, const Work& work, const Take& take) {
    if (chain_ == nullptr) {
      for (std::size_t i = 0; i < slices; ++i) take(work(i, counters_));
      return;
    }
    constexpr int kStalls = 1;
    at_ = &chain_->pass_after(at_, slices, work);
    at_->results.complete(kStalls, at_->maker(counters_, [this] { return is_set(cancelled_); }));
    for (std::size_t i = 0; i < slices; ++i) take(at_->results[i]);
  }

 private:
  PassChain* chain_ = nullptr;
  SharedPass* at_ = nullptr;
  kdtree::BuildCounters& counters_;
  const std::atomic<bool>* cancelled_ = nullptr;
};

}  // namespace sightline::accel::lazy
