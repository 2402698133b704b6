// The recursion over event cells.
#include "accel/published/kd/event_growth.h"

#include <algorithm>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/grow/fork.h"
#include "accel/grow/grow.h"
#include "accel/published/kd/event.h"
#include "accel/published/kd/event_cell.h"
#include "accel/published/kd/sweep_axis.h"

namespace sightline::accel::published::kd {
namespace {

constexpr std::size_t kAxes = 3;

template <class Weights>
class EventGrowth {
 public:
  EventGrowth(const grow::GrowContext& context, const ExactBuilder& builder,
              std::span<const kdtree::Reference> refs, Weights weights)
      : context_(context),
        builder_(builder),
        mesh_(builder.clips() ? context.mesh : nullptr),
        refs_(refs),
        weights_(weights) {}

  kdtree::Slot grow(const EventCell& cell, EventDivider& divider, kdtree::BuildCounters& counters) {
    const bool cancelled =
        context_.cancelled != nullptr && context_.cancelled->load(std::memory_order_relaxed);
    if (cell.size >= grow::kForkFrom && cancelled)
      return defer(cell, kdtree::KdTree::Waits::kLeftOver);
    const std::optional<EventSplit> cut = choose(cell, counters);
    if (!cut) return leaf(cell);
    const std::optional<std::uint32_t> pair = context_.tree.allocate_pair();
    if (!pair) return defer(cell, kdtree::KdTree::Waits::kFailed);

    const auto mark = divider.events().mark();
    const EventHalves halves = divider.divide(cell, *cut, refs_, mesh_, counters);
    const kdtree::Slot slot = kdtree::Slot::binary(cut->cut.plane, *pair);
    kdtree::AtomicSlot* children = context_.tree.children(slot);
    const auto grow_child = [&](std::size_t i, EventDivider& own, kdtree::BuildCounters& sum) {
      // Not published until the slot of the whole subtree is.
      children[i].store(grow(i == 0 ? halves.left : halves.right, own, sum).bits(),
                        std::memory_order_relaxed);
    };
    if (std::min(halves.left.size, halves.right.size) >= grow::kForkFrom) {
      kdtree::BuildCounters right;
      grow::fork([&] { grow_child(0, divider, counters); },
                 [&] {
                   EventDivider own(refs_.size());
                   grow_child(1, own, right);
                 });
      counters += right;
    } else {
      grow_child(0, divider, counters);
      grow_child(1, divider, counters);
    }
    divider.events().release(mark);
    return slot;
  }

 private:
  std::optional<EventSplit> choose(const EventCell& cell, kdtree::BuildCounters& counters) const {
    if (cell.size == 0 || cell.path.depth >= context_.max_depth || !(half_area(cell.box) > 0))
      return std::nullopt;
    Candidate best;
    for (const int axis : {0, 1, 2}) {
      const std::span<const Event> events = cell.events[static_cast<std::size_t>(axis)];
      sweep_axis(events, AxisCuts(builder_.costs, cell.box, axis, cell.weight), cell.weight,
                 weights_, best);
      counters.touches += events.size() / 2;
    }
    const std::optional<kdtree::Split> cut =
        builder_.decide(best, cell.weight, cell.size, cell.path);
    if (!cut) return std::nullopt;
    return EventSplit{*cut, best.left, best.right};
  }

  kdtree::Slot leaf(const EventCell& cell) const {
    if (cell.size == 0) return kdtree::Slot::empty_leaf();
    std::vector<kdtree::Reference> refs;
    refs.reserve(cell.size);
    for (const Event event : cell.events[0]) {
      if (event.type() != EventType::kEnd) refs.push_back(refs_[event.reference()]);
    }
    const std::optional<kdtree::Slot> made = context_.tree.make_leaf(refs);
    return made ? *made : defer(cell, kdtree::KdTree::Waits::kFailed);
  }

  /// Makes a list again: every reference with the bounds of its events.
  kdtree::Slot defer(const EventCell& cell, kdtree::KdTree::Waits why) const {
    std::vector<std::uint32_t> members;
    for (const Event event : cell.events[0]) {
      if (event.type() != EventType::kEnd) members.push_back(event.reference());
    }
    std::sort(members.begin(), members.end());
    kdtree::ReferenceList list(members.size());
    const std::span<kdtree::Reference> refs = list.all();
    std::transform(members.begin(), members.end(), refs.begin(),
                   [&](std::uint32_t m) { return refs_[m]; });
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      for (const Event event : cell.events[axis]) {
        const auto index =
            std::lower_bound(members.begin(), members.end(), event.reference()) - members.begin();
        kdtree::Reference& ref = refs[static_cast<std::size_t>(index)];
        if (event.type() != EventType::kEnd) ref.lo[axis] = event.position();
        if (event.type() == EventType::kEnd) ref.hi[axis] = event.position();
        if (event.type() == EventType::kPlanar)
          ref.hi[axis] = geometry::least_above(event.position());
      }
    }
    return context_.tree.defer(std::move(list), cell.box, cell.path, why);
  }

  const grow::GrowContext& context_;
  const ExactBuilder& builder_;
  const geometry::MeshView* mesh_;
  std::span<const kdtree::Reference> refs_;
  Weights weights_;
};

std::vector<Event> sorted_events(std::span<const kdtree::Reference> refs, std::size_t axis) {
  std::vector<Event> events(2 * refs.size());
  Event* end = events.data();
  for (std::size_t i = 0; i < refs.size(); ++i) {
    end = put_events(refs[i].lo[axis], refs[i].hi[axis], static_cast<std::uint32_t>(i), end);
  }
  events.resize(static_cast<std::size_t>(end - events.data()));
  sort_events(events);
  return events;
}

}  // namespace

kdtree::Slot grow_by_events(const grow::GrowContext& context, const ExactBuilder& builder,
                            std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                            const kdtree::CellPath& path, kdtree::BuildCounters& counters) {
  std::array<std::vector<Event>, kAxes> events;
  if (refs.size() >= grow::kForkFrom) {
    tbb::parallel_for(std::size_t{0}, kAxes,
                      [&](std::size_t axis) { events[axis] = sorted_events(refs, axis); });
  } else {
    for (std::size_t axis = 0; axis < kAxes; ++axis) events[axis] = sorted_events(refs, axis);
  }
  counters.touches += refs.size();
  EventCell root{{}, refs.size(), 0, cell, path};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    root.events[axis] = events[axis];
    counters.touches += sort_touches(events[axis].size());
  }
  for (const kdtree::Reference& ref : refs) root.weight += ref.weight;
  EventDivider divider(refs.size());
  const bool unit = std::all_of(refs.begin(), refs.end(),
                                [](const kdtree::Reference& ref) { return ref.weight == 1; });
  if (unit) {
    return EventGrowth(context, builder, refs, UnitWeights{}).grow(root, divider, counters);
  }
  return EventGrowth(context, builder, refs, ListWeights{refs}).grow(root, divider, counters);
}

}  // namespace sightline::accel::published::kd
