// Expanding deferred cells: build off to the side, publish with one store, retire.
#include "accel/lazy/lazy_tree.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <thread>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include "accel/grow/grow.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/stall_detector.h"
#include "accel/split/reference_budget.h"

namespace sightline::accel::lazy {
namespace {

/// Full builds cut cells above this weight one by one, with all threads, and give the others each
/// to one thread.
constexpr std::uint64_t kWholeBelow = 65536;

std::uint64_t weight_of(const Part& part) {
  if (!part.openable) return part.list.size();
  std::uint64_t weight = 0;
  part.list.any_part([&](std::span<const kdtree::BoxRef> refs) {
    for (const kdtree::BoxRef& ref : refs) weight += ref.weight;
    return false;
  });
  return weight;
}

/// What the cuts of a tree over so many references may add.
double budget(const split::SplitSearch& rule, std::size_t references) {
  if (rule.budget() == 0) return std::numeric_limits<double>::infinity();
  return (rule.budget() - 1) * static_cast<double>(references);
}

/// Adds the time of its life.
class Timed {
 public:
  explicit Timed(kdtree::BuildCounters& counters) : counters_(counters) {}
  ~Timed() {
    counters_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  kdtree::BuildCounters& counters_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// All slots with something to expand.
void collect_unbuilt(const kdtree::KdTree& tree, kdtree::AtomicSlot& slot,
                     std::vector<kdtree::AtomicSlot*>& found) {
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_unbuilt() && !now.cell()->given_up.load(std::memory_order_relaxed))
    found.push_back(&slot);
  if (!now.is_binary()) return;
  kdtree::AtomicSlot* children = tree.children(now);
  collect_unbuilt(tree, children[0], found);
  collect_unbuilt(tree, children[1], found);
}

bool is_large(const kdtree::DeferredCell& cell) {
  return !cell.listed || cell.list.sliced() != nullptr;
}

Expansion& expansion_of(kdtree::DeferredCell& cell, const ReferenceSource& source, bool& fresh) {
  kdtree::SharedWork* work = cell.expansion.load(std::memory_order_acquire);
  fresh = false;
  if (work == nullptr) {
    auto* mine = new Expansion(source.alive);
    fresh = cell.expansion.compare_exchange_strong(work, mine, std::memory_order_acq_rel);
    if (fresh) return *mine;
    mine->leave();
  }
  return static_cast<Expansion&>(*work);
}

}  // namespace

/// What a division into several parts leaves to them.
struct LazyTree::Shares {
  double each = std::numeric_limits<double>::infinity();  ///< For a unit of demand.
  double swell = 1;                                       ///< Of the parts.

  Shares(const Division& division, const kdtree::DeferredCell& cell) {
    if (std::isinf(cell.path.spare)) return;
    const auto before = static_cast<double>(cell.size);
    double after = 0;
    for (const Part& part : division.parts) after += static_cast<double>(part.list.size());
    swell = cell.path.swell * std::max(1.0, after / before);
    double demands = 0;
    for (std::size_t p = 0; p < division.parts.size(); ++p) demands += of(division, p);
    each = demands > 0 ? split::left_over(cell.path, before, after) / demands : 0;
  }

  double of(const Division& division, std::size_t part) const {
    return split::demand(division.cuts->parts()[part].box,
                         static_cast<double>(division.parts[part].list.size()));
  }
};

LazyTree::LazyTree(const geometry::Aabb& bounds, std::size_t closed, split::SplitRule rule,
                   ReferenceSource source, const geometry::MeshView* mesh)
    : tree_(bounds, closed, {.spare = budget(*rule, closed)}),
      rule_(std::move(rule)),
      source_(std::move(source)),
      closed_(closed),
      context_{rule_, source_, mesh, grow::depth_limit(*rule_, closed)} {}

Expanded LazyTree::expand(kdtree::AtomicSlot& slot, AtBusy at_busy,
                          kdtree::BuildCounters& counters) {
  const Timed timed(counters);
  return expand_now(slot, at_busy, counters);
}

Expanded LazyTree::expand_now(kdtree::AtomicSlot& slot, AtBusy at_busy,
                              kdtree::BuildCounters& counters) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_unbuilt()) return Expanded::kAgain;
  kdtree::DeferredCell& cell = *now.cell();
  if (cell.given_up.load(std::memory_order_relaxed)) return Expanded::kSearch;
  if (now.tag() == kdtree::Slot::Tag::kExpanding) return meet_claimed(slot, cell, at_busy);
  try {
    return is_large(cell) ? expand_large(slot, cell, at_busy, counters)
                          : expand_small(slot, cell, counters);
  } catch (const std::bad_alloc&) {
    cell.given_up.store(true, std::memory_order_relaxed);
    return Expanded::kSearch;
  }
}

/// One thread is at it. A short list is searched sooner than that is done; a long one, which a full
/// build finishes whole, only if that takes long.
Expanded LazyTree::meet_claimed(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                                AtBusy at_busy) {
  if (!is_large(cell)) return Expanded::kSearch;
  if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
  for (Patience patience; patience.wait(0);) {
    if (kdtree::load(slot) != kdtree::Slot::expanding(&cell)) return Expanded::kAgain;
  }
  return Expanded::kSearch;
}

std::uint64_t LazyTree::progress(const kdtree::AtomicSlot& slot) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_unbuilt()) return 0;
  const kdtree::SharedWork* work = now.cell()->expansion.load(std::memory_order_acquire);
  return work == nullptr ? 0 : static_cast<const Expansion*>(work)->progress();
}

bool LazyTree::claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  std::uint64_t expected = kdtree::Slot::deferred(&cell).bits();
  return slot.compare_exchange_strong(expected, kdtree::Slot::expanding(&cell).bits(),
                                      std::memory_order_acq_rel);
}

void LazyTree::give_back(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  cell.given_up.store(true, std::memory_order_relaxed);
  slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
}

/// By the one thread that claimed the cell, or that won.
void LazyTree::publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
                       kdtree::BuildCounters& counters) {
  slot.store(built.bits(), std::memory_order_release);
  tree_.retire_cell(cell);
  counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
}

/// The cell's own list is never written: latecomers are reading it.
Expanded LazyTree::expand_small(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                kdtree::BuildCounters& counters) {
  if (!claim(slot, cell))
    return kdtree::load(slot) == kdtree::Slot::expanding(&cell) ? Expanded::kSearch
                                                                : Expanded::kAgain;
  try {
    const kdtree::Slot built = cell.weight <= kFinishBelow
                                   ? finish(cell, counters, nullptr)
                                   : make_slot(divide_short(context_, cell, counters), cell);
    publish(slot, cell, built, counters);
    return Expanded::kAgain;
  } catch (const std::bad_alloc&) {
    give_back(slot, cell);
    return Expanded::kSearch;
  }
}

Expanded LazyTree::expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                AtBusy at_busy, kdtree::BuildCounters& counters) {
  bool fresh = false;
  Expansion& expansion = expansion_of(cell, source_, fresh);
  if (fresh) return lead(slot, cell, expansion, counters);
  for (Patience patience;;) {
    const bool helped = expansion.help(counters);
    if (kdtree::load(slot) != kdtree::Slot::deferred(&cell)) return Expanded::kAgain;
    if (helped) continue;
    if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
    if (!patience.wait(expansion.progress())) return lead(slot, cell, expansion, counters);
  }
}

/// Follows the stages to their end. Several threads may, where the first seemed to be stopped; what
/// the others made is then thrown away.
Expanded LazyTree::lead(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, Expansion& expansion,
                        kdtree::BuildCounters& counters) {
  tree_.reserve(closed_);
  const kdtree::Slot built =
      make_slot(divide_long(context_, cell, Replay(expansion, counters), counters), cell);
  std::uint64_t expected = kdtree::Slot::deferred(&cell).bits();
  if (slot.compare_exchange_strong(expected, built.bits(), std::memory_order_acq_rel)) {
    counters += expansion.take_counters();
    tree_.retire_cell(cell);
    counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
  } else {
    tree_.discard(built);
  }
  return Expanded::kAgain;
}

kdtree::Slot LazyTree::defer(Part part, const geometry::Aabb& box, const kdtree::CellPath& path) {
  auto cell = std::make_unique<kdtree::DeferredCell>();
  cell->box = box;
  cell->path = path;
  cell->openable = part.openable;
  cell->size = part.list.size();
  cell->weight = weight_of(part);
  cell->first = part.first;
  cell->list = std::move(part.list);
  return tree_.defer(std::move(cell));
}

kdtree::Slot LazyTree::make_slot(Division division, const kdtree::DeferredCell& cell) {
  switch (division.kind) {
    case Division::Kind::kLeaf: {
      const kdtree::BoxList whole = cell.list.copy();
      const std::optional<kdtree::Slot> leaf = tree_.make_leaf(whole.all());
      if (!leaf) throw std::bad_alloc();
      return *leaf;
    }
    case Division::Kind::kFiner:
      return defer(std::move(division.left), cell.box, cell.path);
    case Division::Kind::kCuts:
      return make_slot(division, division.cuts->nodes()[0], Shares(division, cell));
    case Division::Kind::kCut:
      break;
  }
  const std::optional<std::uint32_t> pair = tree_.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const kdtree::Plane& plane = division.cut.plane;
  const kdtree::Slot slot = kdtree::Slot::binary(plane, *pair);
  const geometry::HalvedCell halves = halve(cell.box, plane.axis, plane.position);
  const auto weight = [](const Part& part) { return static_cast<double>(weight_of(part)); };
  const split::HalvedPath path =
      split::halve_path(division.path, division.cut, halves, static_cast<double>(cell.weight),
                        weight(division.left), weight(division.right));
  kdtree::AtomicSlot* children = tree_.children(slot);
  children[0].store(defer(std::move(division.left), halves.left, path.left).bits(),
                    std::memory_order_relaxed);
  children[1].store(defer(std::move(division.right), halves.right, path.right).bits(),
                    std::memory_order_relaxed);
  return slot;
}

kdtree::Slot LazyTree::make_slot(Division& division, const CutTree::Node& node,
                                 const Shares& shares) {
  const std::optional<std::uint32_t> pair = tree_.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const kdtree::Slot slot = kdtree::Slot::binary(node.cut.plane, *pair);
  const auto below = [&](const CutTree::Child& child) {
    if (!child.is_part) return make_slot(division, division.cuts->nodes()[child.place], shares);
    const CutTree::Part& cut = division.cuts->parts()[child.place];
    Part& part = division.parts[child.place];
    kdtree::CellPath path = cut.path;
    if (!std::isinf(path.spare)) {
      path.spare = shares.each * shares.of(division, child.place);
      path.swell = shares.swell;
    }
    return defer(std::move(part), cut.box, path);
  };
  kdtree::AtomicSlot* children = tree_.children(slot);
  children[0].store(below(node.left).bits(), std::memory_order_relaxed);
  children[1].store(below(node.right).bits(), std::memory_order_relaxed);
  return slot;
}

kdtree::Slot LazyTree::finish(const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters,
                              const std::atomic<bool>* cancelled) {
  kdtree::BoxList list = cell.list.copy();
  if (cell.openable) list = open_all(source_, std::move(list), cell.box, counters);
  const grow::GrowContext context{tree_, *rule_, context_.mesh, context_.max_depth, cancelled};
  return grow::grow(context, list.all(), cell.box, cell.path, counters);
}

void LazyTree::expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  const kdtree::EpochPin pin;
  const Timed timed(counters);
  // A round completes all that was unbuilt when it began; rays may have claimed some of it.
  for (;;) {
    std::vector<kdtree::AtomicSlot*> unbuilt;
    collect_unbuilt(tree_, tree_.root(), unbuilt);
    if (unbuilt.empty() || (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)))
      return;
    counters += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, unbuilt.size()), kdtree::BuildCounters{},
        [&](const tbb::blocked_range<std::size_t>& range, kdtree::BuildCounters sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i)
            complete(*unbuilt[i], sum, cancelled);
          return sum;
        },
        [](kdtree::BuildCounters a, const kdtree::BuildCounters& b) { return a += b; });
  }
}

/// Until the slot is built, and what was cut off in doing so.
void LazyTree::complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                        const std::atomic<bool>* cancelled) {
  const kdtree::EpochPin pin;
  Patience patience;
  for (kdtree::Slot now = kdtree::load(slot); now.is_unbuilt(); now = kdtree::load(slot)) {
    kdtree::DeferredCell& cell = *now.cell();
    if (cell.given_up.load(std::memory_order_relaxed)) return;
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) return;
    if (!cell.listed || cell.weight > kWholeBelow) {
      if (expand_now(slot, AtBusy::kWait, counters) != Expanded::kSearch) continue;
    } else if (claim(slot, cell)) {
      return complete_cell(slot, cell, counters, cancelled);
    }
    // A ray's thread has just claimed it and is done in no time, or has stopped; then the next
    // round sees to it.
    if (!patience.wait(0)) return;
  }
  const kdtree::Slot built = kdtree::load(slot);
  if (!built.is_binary()) return;
  kdtree::AtomicSlot* children = tree_.children(built);
  kdtree::BuildCounters right;
  tbb::parallel_invoke([&] { complete(children[0], counters, cancelled); },
                       [&] { complete(children[1], right, cancelled); });
  counters += right;
}

void LazyTree::complete_cell(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                             kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  try {
    publish(slot, cell, finish(cell, counters, cancelled), counters);
  } catch (const std::bad_alloc&) {
    give_back(slot, cell);
  }
}

}  // namespace sightline::accel::lazy
