// Divides the sorted events of a cell without sorting them again.
#include "accel/published/kd/event_cell.h"

#include <algorithm>

#include "accel/grow/clip_straddlers.h"

namespace sightline::accel::published::kd {
namespace {

enum Side : std::uint8_t { kNeither = 0, kLeft = 1, kRight = 2, kBoth = 3 };

/// Insertion is faster for few events, and in a good tree there are few.
void sort_fresh(Event* begin, Event* end) {
  if (end - begin > 24) return std::sort(begin, end);
  for (Event* next = begin; next != end; ++next) {
    const Event event = *next;
    Event* at = next;
    for (; at != begin && event < at[-1]; --at) *at = at[-1];
    *at = event;
  }
}

/// Merges two lists without branches on events, as which list is next is hard to predict.
Event* merge(const Event* a, const Event* a_end, const Event* b, const Event* b_end, Event* out) {
  while (a != a_end && b != b_end) {
    const bool second = *b < *a;
    *out++ = second ? *b : *a;
    a += second ? 0 : 1;
    b += second ? 1 : 0;
  }
  out = std::copy(a, a_end, out);
  return std::copy(b, b_end, out);
}

}  // namespace

std::size_t EventDivider::classify(std::span<const Event> events, const kdtree::Split& cut) {
  const float x = cut.plane.position;
  const std::size_t size = events.size();
  std::uint8_t* side = side_.get();
  std::size_t started = 0, ended = 0, i = 0;
  for (; i < size && events[i].position() < x; ++i) {
    const bool starts = events[i].type() == EventType::kStart;
    side[events[i].reference()] = starts ? kBoth : kLeft;
    started += starts ? 1 : 0;
    ended += events[i].type() == EventType::kEnd ? 1 : 0;
  }
  std::size_t planar_left = i - started - ended;
  for (; i < size && events[i].position() == x; ++i) {
    const bool ends = events[i].type() == EventType::kEnd;
    const bool goes_left = events[i].type() == EventType::kPlanar && cut.planar_left;
    side[events[i].reference()] = ends || goes_left ? kLeft : kRight;
    ended += ends ? 1 : 0;
    planar_left += goes_left ? 1 : 0;
  }
  straddling_ = started - ended;
  // There is capacity for one more, as the loop writes before it tests.
  if (straddlers_.size() < straddling_ + 1) straddlers_.resize(straddling_ + 1);
  std::size_t found = 0;
  for (; i < size; ++i) {
    const std::uint32_t reference = events[i].reference();
    const bool ends = events[i].type() == EventType::kEnd;
    const std::uint8_t before = side[reference];
    side[reference] = ends ? before : std::uint8_t{kRight};
    straddlers_[found] = reference;
    found += ends && before == kBoth ? 1 : 0;
  }
  return ended + planar_left;
}

void EventDivider::clip(EventCell& half, std::array<EventBuffer, 3>& fresh,
                        std::span<const kdtree::Reference> refs, const geometry::MeshView& mesh) {
  for (EventBuffer& buffer : fresh) buffer.clear(2 * straddling_);
  for (const std::uint32_t reference : std::span(straddlers_).first(straddling_)) {
    const std::optional<geometry::Aabb> box =
        grow::clip_to_half(mesh, refs[reference].id, half.box);
    if (!box) {
      --half.size;
      half.weight -= refs[reference].weight;
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      fresh[axis].end = put_events(box->lo[axis], box->hi[axis], reference, fresh[axis].end);
    }
  }
}

void EventDivider::splice(std::span<const Event> events) {
  for (EventBuffer& buffer : spliced_) buffer.clear(events.size() + 1);
  Event* left = spliced_[0].begin();
  Event* right = spliced_[1].begin();
  const std::uint8_t* sides = side_.get();
  for (const Event event : events) {
    const std::uint8_t side = sides[event.reference()];
    *left = event;
    *right = event;
    left += side & kLeft;
    right += side >> 1;
  }
  spliced_[0].end = left;
  spliced_[1].end = right;
}

std::span<const Event> EventDivider::keep(EventBuffer& spliced, EventBuffer& fresh,
                                          kdtree::BuildCounters& counters) {
  const std::size_t size = spliced.size() + fresh.size();
  Event* out = events_.top(size);
  events_.take(size);
  if (fresh.size() == 0) {
    std::copy(spliced.begin(), spliced.end, out);
    return {out, size};
  }
  sort_fresh(fresh.begin(), fresh.end);
  merge(spliced.begin(), spliced.end, fresh.begin(), fresh.end, out);
  counters.touches += sort_touches(fresh.size()) + size / 2;
  return {out, size};
}

EventHalves EventDivider::divide(const EventCell& cell, const EventSplit& cut,
                                 std::span<const kdtree::Reference> refs,
                                 const geometry::MeshView* mesh, kdtree::BuildCounters& counters) {
  const kdtree::Plane& plane = cut.cut.plane;
  const geometry::HalvedCell boxes = halve(cell.box, plane.axis, plane.position);
  const kdtree::CellPath path = cell.path.below(cut.cut);
  const std::span<const Event> along = cell.events[static_cast<std::size_t>(plane.axis)];
  const std::size_t left_only = classify(along, cut.cut);
  counters.touches += along.size() / 2;
  EventHalves halves;
  halves.left = {{}, left_only + straddling_, cut.left, boxes.left, path};
  halves.right = {{}, cell.size - left_only, cut.right, boxes.right, path};
  for (auto& side : fresh_) {
    for (EventBuffer& buffer : side) buffer.clear(0);
  }
  if (mesh != nullptr && straddling_ > 0) {
    clip(halves.left, fresh_[0], refs, *mesh);
    clip(halves.right, fresh_[1], refs, *mesh);
    for (const std::uint32_t reference : std::span(straddlers_).first(straddling_))
      side_[reference] = kNeither;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    splice(cell.events[axis]);
    counters.touches += cell.events[axis].size() / 2;
    halves.left.events[axis] = keep(spliced_[0], fresh_[0][axis], counters);
    halves.right.events[axis] = keep(spliced_[1], fresh_[1][axis], counters);
  }
  return halves;
}

}  // namespace sightline::accel::published::kd
