// A cell as sorted events, and its division: classify, splice, merge. Source: Wald, Havran
// 2006, section 4.3.1.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/grow/list_stack.h"
#include "accel/published/kd/event.h"

namespace sightline::accel::published::kd {

/// The sorted events of all references of a cell, one array per axis. They are the only copy of its
/// references.
struct EventCell {
  std::array<std::span<const Event>, 3> events;
  std::size_t size = 0;      ///< Number of references.
  std::uint32_t weight = 0;  ///< Sum of the weights of all references.
  geometry::Aabb box;
  kdtree::CellPath path;
};

struct EventHalves {
  EventCell left, right;
};

/// A split and the weights of its sides: see Candidate.
struct EventSplit {
  kdtree::Split cut;
  std::uint32_t left = 0, right = 0;
};

/// Divides cells whose references have indices below `references`. Threads: one; every task has its
/// own.
class EventDivider {
 public:
  explicit EventDivider(std::size_t references)
      : side_(std::make_unique_for_overwrite<std::uint8_t[]>(references)) {}

  /// Memory of the children's events. The caller releases it when the children are finished.
  grow::ListStack<Event>& events() { return events_; }

  /// Divides a cell. If `mesh` is null, straddlers keep their bounds on both sides; otherwise they
  /// are clipped to each half, and left out of a half that they do not overlap. `refs`: face and
  /// weight of each reference, by index.
  EventHalves divide(const EventCell& cell, const EventSplit& cut,
                     std::span<const kdtree::Reference> refs, const geometry::MeshView* mesh,
                     kdtree::BuildCounters& counters);

 private:
  /// Growing buffer of events; the writer advances `end`.
  struct EventBuffer {
    std::vector<Event> events;
    Event* end = nullptr;

    Event* begin() { return events.data(); }
    std::size_t size() { return static_cast<std::size_t>(end - begin()); }
    void clear(std::size_t capacity) {
      if (events.size() < capacity) events.resize(capacity);
      end = begin();
    }
  };
  /// Sets side_ for every reference of the cell, and straddlers_. Returns the number of references
  /// on the left only.
  std::size_t classify(std::span<const Event> events, const kdtree::Split& cut);
  /// Makes the events of all straddlers in one half, and removes from its counts those that only
  /// touch it.
  void clip(EventCell& half, std::array<EventBuffer, 3>& fresh,
            std::span<const kdtree::Reference> refs, const geometry::MeshView& mesh);
  /// Divides the events of one axis by side_, in order.
  void splice(std::span<const Event> events);
  /// Merges spliced and new events into their final memory.
  std::span<const Event> keep(EventBuffer& spliced, EventBuffer& fresh,
                              kdtree::BuildCounters& counters);

  grow::ListStack<Event> events_;
  std::unique_ptr<std::uint8_t[]>
      side_;  ///< Per reference: on the left (bit 0), on the right (bit 1).
  std::vector<std::uint32_t> straddlers_;  ///< The first straddling_ entries are set.
  std::size_t straddling_ = 0;
  std::array<std::array<EventBuffer, 3>, 2>
      fresh_;                           ///< Events of clipped straddlers, by side and axis.
  std::array<EventBuffer, 2> spliced_;  ///< Events of one axis, by side.
};

}  // namespace sightline::accel::published::kd
