// The recursion over event cells.
#include "accel/published/kd/event_growth.h"

#include <algorithm>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/grow/fork.h"
#include "accel/published/kd/event.h"
#include "accel/published/kd/event_cell.h"
#include "accel/published/kd/fork_children.h"
#include "accel/published/kd/sweep_axis.h"

namespace sightline::accel::published::kd {
namespace {

constexpr std::size_t kAxes = 3;

class EventGrowth {
 public:
  EventGrowth(const ExactBuilder& builder, const geometry::MeshView& mesh, int max_depth,
              std::span<const kdtree::Reference> refs)
      : builder_(builder),
        mesh_(builder.clips() ? &mesh : nullptr),
        max_depth_(max_depth),
        refs_(refs) {}

  PlainNode grow(const EventCell& cell, EventDivider& divider, const PlainTask& task) const {
    const std::optional<EventSplit> cut = choose(cell, task.counters);
    if (!cut) return leaf(cell, task);
    if (!task.out.may_cut()) return failed_leaf(cell, task);
    const std::uint32_t pair = task.out.begin_pair();
    const auto mark = divider.events().mark();
    const EventHalves halves = divider.divide(cell, *cut, refs_, mesh_, task.counters);
    const PlainCells::Pair children = grow_children(halves, divider, task);
    divider.events().release(mark);
    task.out.end_pair(pair, children[0], children[1]);
    return PlainNode::inner(cut->cut.plane, pair);
  }

 private:
  PlainCells::Pair grow_children(const EventHalves& halves, EventDivider& divider,
                                 const PlainTask& task) const {
    if (std::min(halves.left.size, halves.right.size) < grow::kForkFrom) {
      const PlainNode left = grow(halves.left, divider, task);
      return {left, grow(halves.right, divider, task)};
    }
    const auto grow_left = [&] { return grow(halves.left, divider, task); };
    return fork_children(task, grow_left, [&](const PlainTask& by, bool goes_on) {
      if (goes_on) return grow(halves.right, divider, by);
      EventDivider own(refs_.size());
      return grow(halves.right, own, by);
    });
  }

  std::optional<EventSplit> choose(const EventCell& cell, kdtree::BuildCounters& counters) const {
    if (cell.size == 0 || cell.path.depth >= max_depth_ || !(half_area(cell.box) > 0))
      return std::nullopt;
    Candidate best;
    for (const int axis : {0, 1, 2}) {
      const std::span<const Event> events = cell.events[static_cast<std::size_t>(axis)];
      sweep_axis(events, AxisCuts(builder_.costs, cell.box, axis, cell.weight), cell.weight,
                 UnitWeights{}, best);
      counters.touches += events.size() / 2;
    }
    const std::optional<kdtree::Split> cut =
        builder_.decide(best, cell.weight, cell.size, cell.path);
    if (!cut) return std::nullopt;
    return EventSplit{*cut, best.left, best.right};
  }

  PlainNode leaf(const EventCell& cell, const PlainTask& task) const {
    std::vector<kdtree::Reference> refs;
    refs.reserve(cell.size);
    for (const Event event : cell.events[0]) {
      if (event.type() != EventType::kEnd) refs.push_back(refs_[event.reference()]);
    }
    return task.out.leaf(refs, [&] { return failed_leaf(cell, task); });
  }

  /// Rebuilds a list: every reference with the bounds of its events.
  PlainNode failed_leaf(const EventCell& cell, const PlainTask& task) const {
    std::vector<std::uint32_t> members;
    for (const Event event : cell.events[0]) {
      if (event.type() != EventType::kEnd) members.push_back(event.reference());
    }
    std::sort(members.begin(), members.end());
    std::vector<kdtree::Reference> refs(members.size());
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
    return task.out.failed_leaf(refs);
  }

  const ExactBuilder& builder_;
  const geometry::MeshView* mesh_;
  const int max_depth_;
  std::span<const kdtree::Reference> refs_;
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

PlainNode grow_by_events(const ExactBuilder& builder, const geometry::MeshView& mesh, int max_depth,
                         std::span<const kdtree::Reference> refs, const geometry::Aabb& bounds,
                         const PlainTask& task) {
  std::array<std::vector<Event>, kAxes> events;
  if (refs.size() >= grow::kForkFrom) {
    tbb::parallel_for(std::size_t{0}, kAxes,
                      [&](std::size_t axis) { events[axis] = sorted_events(refs, axis); });
  } else {
    for (std::size_t axis = 0; axis < kAxes; ++axis) events[axis] = sorted_events(refs, axis);
  }
  task.counters.touches += refs.size();
  EventCell root{{}, refs.size(), static_cast<std::uint32_t>(refs.size()), bounds, {}};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    root.events[axis] = events[axis];
    task.counters.touches += sort_touches(events[axis].size());
  }
  EventDivider divider(refs.size());
  return EventGrowth(builder, mesh, max_depth, refs).grow(root, divider, task);
}

}  // namespace sightline::accel::published::kd
