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
#include "accel/grow/opening.h"
#include "accel/grow/reference_budget.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/stall_detector.h"

namespace sightline::accel {
namespace {

/// Full builds cut cells above this weight one by one, with all threads, and give the others each
/// to one thread.
constexpr std::uint64_t kWholeBelow = 65536;

std::uint64_t weight_of(const Part& part) {
  if (!part.openable) return part.list.size();
  std::uint64_t weight = 0;
  part.list.any_part([&](std::span<const BoxRef> refs) {
    for (const BoxRef& ref : refs) weight += ref.weight;
    return false;
  });
  return weight;
}

/// What the cuts of a tree over so many references may add.
double budget(const KdBuilder& builder, std::size_t references) {
  const auto* scan = std::get_if<ScanBuilder>(&builder);
  if (scan == nullptr || scan->budget == 0) return std::numeric_limits<double>::infinity();
  return (scan->budget - 1) * static_cast<double>(references);
}

/// Adds the time of its life.
class Timed {
 public:
  explicit Timed(BuildCounters& counters) : counters_(counters) {}
  ~Timed() {
    counters_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  BuildCounters& counters_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// All slots with something to expand.
void collect_unbuilt(const KdTree& tree, AtomicSlot& slot, std::vector<AtomicSlot*>& found) {
  const Slot now = load(slot);
  if (now.is_unbuilt() && !now.cell()->given_up.load(std::memory_order_relaxed))
    found.push_back(&slot);
  if (!now.is_binary()) return;
  AtomicSlot* children = tree.children(now);
  collect_unbuilt(tree, children[0], found);
  collect_unbuilt(tree, children[1], found);
}

bool is_large(const DeferredCell& cell) { return !cell.listed || cell.list.sliced() != nullptr; }

Expansion& expansion_of(DeferredCell& cell, const ReferenceSource& source, bool& fresh) {
  SharedWork* work = cell.expansion.load(std::memory_order_acquire);
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
  bool parted_little = false;
  double swell = 1;  ///< Of the parts.

  Shares(const Division& division, const DeferredCell& cell) {
    if (std::isinf(cell.path.spare)) return;
    const auto before = static_cast<double>(cell.size);
    double after = 0;
    for (const Part& part : division.parts) after += static_cast<double>(part.list.size());
    parted_little = parts_little(cell.path, before, after);
    swell = cell.path.swell * std::max(1.0, after / before);
    double demands = 0;
    for (std::size_t p = 0; p < division.parts.size(); ++p) demands += of(division, p);
    each = demands > 0 ? left_over(cell.path, before, after) / demands : 0;
  }

  double of(const Division& division, std::size_t part) const {
    return demand(division.cuts->parts()[part].box,
                  static_cast<double>(division.parts[part].list.size()), parted_little);
  }
};

LazyTree::LazyTree(const Aabb& bounds, std::size_t closed, const KdBuilder& builder,
                   ReferenceSource source, const MeshView* mesh)
    : tree_(bounds, closed, {.spare = budget(builder, closed)}),
      builder_(builder),
      source_(std::move(source)),
      closed_(closed),
      context_{builder_, source_, mesh, depth_limit(builder, closed)} {}

Expanded LazyTree::expand(AtomicSlot& slot, AtBusy at_busy, BuildCounters& counters) {
  const Timed timed(counters);
  return expand_now(slot, at_busy, counters);
}

Expanded LazyTree::expand_now(AtomicSlot& slot, AtBusy at_busy, BuildCounters& counters) {
  const Slot now = load(slot);
  if (!now.is_unbuilt()) return Expanded::kAgain;
  DeferredCell& cell = *now.cell();
  if (cell.given_up.load(std::memory_order_relaxed)) return Expanded::kSearch;
  if (now.tag() == Slot::Tag::kExpanding) return meet_claimed(slot, cell, at_busy);
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
Expanded LazyTree::meet_claimed(AtomicSlot& slot, const DeferredCell& cell, AtBusy at_busy) {
  if (!is_large(cell)) return Expanded::kSearch;
  if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
  for (Patience patience; patience.wait(0);) {
    if (load(slot) != Slot::expanding(&cell)) return Expanded::kAgain;
  }
  return Expanded::kSearch;
}

std::uint64_t LazyTree::progress(const AtomicSlot& slot) {
  const Slot now = load(slot);
  if (!now.is_unbuilt()) return 0;
  const SharedWork* work = now.cell()->expansion.load(std::memory_order_acquire);
  return work == nullptr ? 0 : static_cast<const Expansion*>(work)->progress();
}

bool LazyTree::claim(AtomicSlot& slot, DeferredCell& cell) {
  std::uint64_t expected = Slot::deferred(&cell).bits();
  return slot.compare_exchange_strong(expected, Slot::expanding(&cell).bits(),
                                      std::memory_order_acq_rel);
}

void LazyTree::give_back(AtomicSlot& slot, DeferredCell& cell) {
  cell.given_up.store(true, std::memory_order_relaxed);
  slot.store(Slot::deferred(&cell).bits(), std::memory_order_release);
}

/// By the one thread that claimed the cell, or that won.
void LazyTree::publish(AtomicSlot& slot, DeferredCell& cell, Slot built, BuildCounters& counters) {
  slot.store(built.bits(), std::memory_order_release);
  tree_.retire_cell(cell);
  counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
}

/// The cell's own list is never written: latecomers are reading it.
Expanded LazyTree::expand_small(AtomicSlot& slot, DeferredCell& cell, BuildCounters& counters) {
  if (!claim(slot, cell))
    return load(slot) == Slot::expanding(&cell) ? Expanded::kSearch : Expanded::kAgain;
  try {
    const Slot built = cell.weight <= kFinishBelow
                           ? finish(cell, counters, nullptr)
                           : make_slot(divide_short(context_, cell, counters), cell);
    publish(slot, cell, built, counters);
    return Expanded::kAgain;
  } catch (const std::bad_alloc&) {
    give_back(slot, cell);
    return Expanded::kSearch;
  }
}

Expanded LazyTree::expand_large(AtomicSlot& slot, DeferredCell& cell, AtBusy at_busy,
                                BuildCounters& counters) {
  bool fresh = false;
  Expansion& expansion = expansion_of(cell, source_, fresh);
  if (fresh) return lead(slot, cell, expansion, counters);
  for (Patience patience;;) {
    const bool helped = expansion.help(counters);
    if (load(slot) != Slot::deferred(&cell)) return Expanded::kAgain;
    if (helped) continue;
    if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
    if (!patience.wait(expansion.progress())) return lead(slot, cell, expansion, counters);
  }
}

/// Follows the stages to their end. Several threads may, where the first seemed to be stopped; what
/// the others made is then thrown away.
Expanded LazyTree::lead(AtomicSlot& slot, DeferredCell& cell, Expansion& expansion,
                        BuildCounters& counters) {
  tree_.reserve(closed_);
  const Slot built =
      make_slot(divide_long(context_, cell, Replay(expansion, counters), counters), cell);
  std::uint64_t expected = Slot::deferred(&cell).bits();
  if (slot.compare_exchange_strong(expected, built.bits(), std::memory_order_acq_rel)) {
    counters += expansion.take_counters();
    tree_.retire_cell(cell);
    counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
  } else {
    tree_.discard(built);
  }
  return Expanded::kAgain;
}

Slot LazyTree::defer(Part part, const Aabb& box, const CellPath& path) {
  auto cell = std::make_unique<DeferredCell>();
  cell->box = box;
  cell->path = path;
  cell->openable = part.openable;
  cell->size = part.list.size();
  cell->weight = weight_of(part);
  cell->first = part.first;
  cell->list = std::move(part.list);
  return tree_.defer(std::move(cell));
}

Slot LazyTree::make_slot(Division division, const DeferredCell& cell) {
  switch (division.kind) {
    case Division::Kind::kLeaf: {
      const BoxList whole = cell.list.copy();
      const std::optional<Slot> leaf = tree_.make_leaf(whole.all());
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
  const Plane& plane = division.cut.plane;
  const Slot slot = Slot::binary(plane, *pair);
  const HalvedCell halves = halve(cell.box, plane.axis, plane.position);
  const auto weight = [](const Part& part) { return static_cast<double>(weight_of(part)); };
  const HalvedPath path =
      halve_path(division.path, division.cut, halves, static_cast<double>(cell.weight),
                 weight(division.left), weight(division.right));
  AtomicSlot* children = tree_.children(slot);
  children[0].store(defer(std::move(division.left), halves.left, path.left).bits(),
                    std::memory_order_relaxed);
  children[1].store(defer(std::move(division.right), halves.right, path.right).bits(),
                    std::memory_order_relaxed);
  return slot;
}

Slot LazyTree::make_slot(Division& division, const CutTree::Node& node, const Shares& shares) {
  const std::optional<std::uint32_t> pair = tree_.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const Slot slot = Slot::binary(node.cut.plane, *pair);
  const auto below = [&](const CutTree::Child& child) {
    if (!child.is_part) return make_slot(division, division.cuts->nodes()[child.place], shares);
    const CutTree::Part& cut = division.cuts->parts()[child.place];
    Part& part = division.parts[child.place];
    CellPath path = cut.path;
    if (!std::isinf(path.spare)) {
      path.spare = shares.each * shares.of(division, child.place);
      path.swell = shares.swell;
    }
    return defer(std::move(part), cut.box, path);
  };
  AtomicSlot* children = tree_.children(slot);
  children[0].store(below(node.left).bits(), std::memory_order_relaxed);
  children[1].store(below(node.right).bits(), std::memory_order_relaxed);
  return slot;
}

Slot LazyTree::finish(const DeferredCell& cell, BuildCounters& counters,
                      const std::atomic<bool>* cancelled) {
  BoxList list = cell.list.copy();
  if (cell.openable) list = open_all(source_, std::move(list), cell.box, counters);
  const GrowContext context{tree_, builder_, context_.mesh, context_.max_depth, cancelled};
  return grow(context, list.all(), cell.box, cell.path, counters);
}

void LazyTree::expand_all(BuildCounters& counters, const std::atomic<bool>* cancelled) {
  const EpochPin pin;
  const Timed timed(counters);
  // A round completes all that was unbuilt when it began; rays may have claimed some of it.
  for (;;) {
    std::vector<AtomicSlot*> unbuilt;
    collect_unbuilt(tree_, tree_.root(), unbuilt);
    if (unbuilt.empty() || (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)))
      return;
    counters += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, unbuilt.size()), BuildCounters{},
        [&](const tbb::blocked_range<std::size_t>& range, BuildCounters sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i)
            complete(*unbuilt[i], sum, cancelled);
          return sum;
        },
        [](BuildCounters a, const BuildCounters& b) { return a += b; });
  }
}

/// Until the slot is built, and what was cut off in doing so.
void LazyTree::complete(AtomicSlot& slot, BuildCounters& counters,
                        const std::atomic<bool>* cancelled) {
  const EpochPin pin;
  Patience patience;
  for (Slot now = load(slot); now.is_unbuilt(); now = load(slot)) {
    DeferredCell& cell = *now.cell();
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
  const Slot built = load(slot);
  if (!built.is_binary()) return;
  AtomicSlot* children = tree_.children(built);
  BuildCounters right;
  tbb::parallel_invoke([&] { complete(children[0], counters, cancelled); },
                       [&] { complete(children[1], right, cancelled); });
  counters += right;
}

void LazyTree::complete_cell(AtomicSlot& slot, DeferredCell& cell, BuildCounters& counters,
                             const std::atomic<bool>* cancelled) {
  try {
    publish(slot, cell, finish(cell, counters, cancelled), counters);
  } catch (const std::bad_alloc&) {
    give_back(slot, cell);
  }
}

}  // namespace sightline::accel
