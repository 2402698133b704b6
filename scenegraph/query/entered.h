// Which instances rays have entered: an instance lies in several cells of the scene's tree.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::scenegraph::query {

/// The instances that the rays of a packet entered last. A forgotten one costs only time: a hit is
/// then found twice.
class RecentLanes {
 public:
  /// Returns the rays of `lanes` that had not entered the instance, which they do now.
  std::uint32_t add(std::uint32_t id, std::uint32_t lanes) {
    for (Entry& entry : entries_) {
      if (entry.lanes == 0 || entry.id != id) continue;
      const std::uint32_t fresh = lanes & ~entry.lanes;
      entry.lanes |= lanes;
      return fresh;
    }
    entries_[next_++ % entries_.size()] = {id, lanes};
    return lanes;
  }

 private:
  struct Entry {
    std::uint32_t id = 0, lanes = 0;
  };
  std::array<Entry, 16> entries_;
  std::size_t next_ = 0;
};

/// All instances that a ray has entered, for counting hits. This is a hash table that keeps its
/// memory for the next ray.
class EnteredOnce {
 public:
  /// Forgets all, in constant time.
  void clear() {
    count_ = 0;
    if (++ray_ == 0) {
      std::fill(slots_.begin(), slots_.end(), Slot{});
      ray_ = 1;
    }
  }

  /// Adds an instance; false if it was there before.
  bool add(std::uint32_t id) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = find(id);
    if (slot.ray == ray_) return false;
    slot = {ray_, id};
    ++count_;
    return true;
  }

 private:
  struct Slot {
    std::uint32_t ray = 0;  // the slot is taken if this is the current ray
    std::uint32_t id = 0;
  };

  // The id's slot, or the free slot for it.
  Slot& find(std::uint32_t id) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = (id * std::size_t{0x9e3779b97f4a7c15u} >> 32) & mask;
    while (slots_[at].ray == ray_ && slots_[at].id != id) at = (at + 1) & mask;
    return slots_[at];
  }

  void grow() {
    std::vector<Slot> before(std::max<std::size_t>(64, 2 * slots_.size()));
    before.swap(slots_);
    for (const Slot& slot : before) {
      if (slot.ray == ray_) find(slot.id) = slot;
    }
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
  std::uint32_t ray_ = 1;
};

}  // namespace sightline::scenegraph::query
