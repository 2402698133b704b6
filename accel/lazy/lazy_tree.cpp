// Expanding deferred cells: claim, build off to the side, publish with one store, retire.
#include "accel/lazy/lazy_tree.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/build/clip_straddlers.h"
#include "accel/build/sift.h"
#include "accel/tree/epoch.h"

namespace sightline::accel {
namespace {

/// From this size on latecomers join the work, which is parallel inside; below it they search the
/// list meanwhile.
constexpr std::size_t kJoinFrom = 16384;

/// All slots with something to expand.
void collect_unbuilt(const KdTree& tree, AtomicSlot& slot, std::vector<AtomicSlot*>& found) {
  const Slot now = load(slot);
  if (now.is_unbuilt()) found.push_back(&slot);
  if (!now.is_binary()) return;
  AtomicSlot* children = tree.children(now);
  collect_unbuilt(tree, children[0], found);
  collect_unbuilt(tree, children[1], found);
}

}  // namespace

LazyTree::LazyTree(const Aabb& bounds, std::size_t references, const AnyBuilder& builder,
                   ReferenceSource source, const MeshView* mesh)
    : tree_(bounds, references),
      builder_(builder),
      source_(std::move(source)),
      mesh_(mesh),
      references_(references),
      max_depth_(depth_limit(builder, references)) {}

bool LazyTree::expand(AtomicSlot& slot, BuildCounters& counters) {
  const Slot now = load(slot);
  if (!now.is_unbuilt()) return true;
  const auto start = std::chrono::steady_clock::now();
  const bool built = claim_and_build(slot, *now.cell(), Extent::kOneCell, counters, nullptr);
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return built;
}

bool LazyTree::claim_and_build(AtomicSlot& slot, DeferredCell& cell, Extent extent,
                               BuildCounters& counters, const std::atomic<bool>* cancelled) {
  if (cell.given_up.load(std::memory_order_relaxed)) return false;
  if (cell.size >= kJoinFrom) {
    tbb::collaborative_call_once(cell.once,
                                 [&] { build(slot, cell, extent, counters, cancelled); });
    return !load(slot).is_unbuilt();
  }
  std::uint64_t expected = Slot::deferred(&cell).bits();
  if (!slot.compare_exchange_strong(expected, Slot::expanding(&cell).bits(),
                                    std::memory_order_acq_rel)) {
    return !Slot(expected).is_unbuilt();
  }
  return build(slot, cell, extent, counters, cancelled);
}

/// Only the thread that claimed the cell comes here. The cell's own list is never written:
/// latecomers may be reading it.
bool LazyTree::build(AtomicSlot& slot, DeferredCell& cell, Extent extent, BuildCounters& counters,
                     const std::atomic<bool>* cancelled) {
  Slot built;
  try {
    BoxList list;
    if (!cell.listed) {
      tree_.reserve(references_);
      list = source_.list(counters);
    }
    const std::span<const BoxRef> refs =
        cell.listed ? std::as_const(cell.list).all() : std::as_const(list).all();
    if (extent == Extent::kSubtree || refs.size() <= kFinishBelow) {
      if (cell.listed) {
        list = BoxList(refs.size());
        std::copy(refs.begin(), refs.end(), list.all().begin());
      }
      built = finish(std::move(list), cell, counters, cancelled);
    } else {
      built = cut_once(refs, cell, counters);
    }
  } catch (const std::bad_alloc&) {
    cell.given_up.store(true, std::memory_order_relaxed);
    slot.store(Slot::deferred(&cell).bits(), std::memory_order_release);
    return false;
  }
  slot.store(built.bits(), std::memory_order_release);
  tree_.retire_cell(cell);
  ++counters.cells_expanded;
  return !built.is_unbuilt();
}

Slot LazyTree::cut_once(std::span<const BoxRef> refs, const DeferredCell& cell,
                        BuildCounters& counters) {
  const CellRefs list{refs, cell.box, cell.path};
  const std::optional<Cut> cut =
      cell.path.depth < max_depth_
          ? std::visit([&](const auto& builder) { return builder.choose(list, counters); },
                       builder_)
          : std::nullopt;
  const auto leaf = [&] {
    const std::optional<Slot> made = tree_.make_leaf(refs);
    if (!made) throw std::bad_alloc();
    return *made;
  };
  if (!cut) return leaf();
  const Plane& plane = cut->plane;
  BoxList left(refs.size()), right(refs.size());
  Sifted n = sift(refs, *cut, left.all().data(), right.all().data());
  counters.touches += refs.size();
  if (n.left == refs.size() && n.right == refs.size()) return leaf();
  const HalvedCell halves = halve(cell.box, plane.axis, plane.position);
  if (mesh_ != nullptr &&
      std::visit([](const auto& builder) { return builder.clips(); }, builder_)) {
    n.left = clip_straddlers(*mesh_, left.all().first(n.left), plane, halves.left);
    n.right = clip_straddlers(*mesh_, right.all().first(n.right), plane, halves.right);
  }
  left.shrink(n.left);
  right.shrink(n.right);
  const std::optional<std::uint32_t> pair = tree_.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const Slot slot = Slot::binary(plane, *pair);
  const CellPath path = cell.path.below(*cut);
  AtomicSlot* children = tree_.children(slot);
  children[0].store(tree_.defer(std::move(left), halves.left, path).bits(),
                    std::memory_order_relaxed);
  children[1].store(tree_.defer(std::move(right), halves.right, path).bits(),
                    std::memory_order_relaxed);
  return slot;
}

Slot LazyTree::finish(BoxList list, const DeferredCell& cell, BuildCounters& counters,
                      const std::atomic<bool>* cancelled) {
  const GrowContext context{tree_, builder_, mesh_, max_depth_, cancelled};
  return grow(context, list.all(), cell.box, cell.path, counters);
}

void LazyTree::finish_slot(AtomicSlot& slot, BuildCounters& counters,
                           const std::atomic<bool>* cancelled) {
  const EpochPin pin;
  for (Slot now = load(slot); now.is_unbuilt(); now = load(slot)) {
    DeferredCell& cell = *now.cell();
    if (cell.given_up.load(std::memory_order_relaxed)) return;
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) return;
    // A small cell that a ray's thread has just claimed is done in microseconds, and that thread
    // never waits for us.
    if (!claim_and_build(slot, cell, Extent::kSubtree, counters, cancelled))
      std::this_thread::yield();
  }
}

void LazyTree::expand_all(BuildCounters& counters, const std::atomic<bool>* cancelled) {
  const EpochPin pin;
  const auto start = std::chrono::steady_clock::now();
  expand_rounds(counters, cancelled);
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A round expands all that was unbuilt when it began; rays may have claimed some of it meanwhile.
void LazyTree::expand_rounds(BuildCounters& counters, const std::atomic<bool>* cancelled) {
  for (;;) {
    std::vector<AtomicSlot*> unbuilt;
    collect_unbuilt(tree_, tree_.root(), unbuilt);
    std::erase_if(unbuilt, [](AtomicSlot* slot) {
      const Slot now = load(*slot);
      return now.is_unbuilt() && now.cell()->given_up.load(std::memory_order_relaxed);
    });
    if (unbuilt.empty() || (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)))
      return;
    counters += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, unbuilt.size()), BuildCounters{},
        [&](const tbb::blocked_range<std::size_t>& range, BuildCounters sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i)
            finish_slot(*unbuilt[i], sum, cancelled);
          return sum;
        },
        [](BuildCounters a, const BuildCounters& b) { return a += b; });
  }
}

}  // namespace sightline::accel
