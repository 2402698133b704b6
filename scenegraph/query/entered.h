// Which instances a ray has been to: an instance lies in several cells of the scene's tree.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::scenegraph::query {

/// The last few. Forgetting one costs time only, where a hit may be found twice.
class RecentlyEntered {
 public:
  bool contains_or_add(std::uint32_t id) {
    for (const std::uint32_t seen : ids_) {
      if (seen == id) return true;
    }
    ids_[next_++ % ids_.size()] = id;
    return false;
  }

 private:
  std::array<std::uint32_t, 8> ids_{~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u};
  std::size_t next_ = 0;
};

/// All of them, where hits are counted. A hash table whose memory the next ray uses again.
class EnteredOnce {
 public:
  /// Forgets all, in no time.
  void clear() {
    count_ = 0;
    if (++ray_ == 0) {
      std::fill(places_.begin(), places_.end(), Place{});
      ray_ = 1;
    }
  }

  /// False if it was there before.
  bool add(std::uint32_t id) {
    if (2 * (count_ + 1) > places_.size()) grow();
    Place& place = find(id);
    if (place.ray == ray_) return false;
    place = {ray_, id};
    ++count_;
    return true;
  }

 private:
  struct Place {
    std::uint32_t ray = 0;  // taken, if by the ray of now
    std::uint32_t id = 0;
  };

  // The id's place, or the free one where it belongs.
  Place& find(std::uint32_t id) {
    const std::size_t mask = places_.size() - 1;
    std::size_t at = (id * std::size_t{0x9e3779b97f4a7c15u} >> 32) & mask;
    while (places_[at].ray == ray_ && places_[at].id != id) at = (at + 1) & mask;
    return places_[at];
  }

  void grow() {
    std::vector<Place> before(std::max<std::size_t>(64, 2 * places_.size()));
    before.swap(places_);
    for (const Place& place : before) {
      if (place.ray == ray_) find(place.id) = place;
    }
  }

  std::vector<Place> places_;
  std::size_t count_ = 0;
  std::uint32_t ray_ = 1;
};

}  // namespace sightline::scenegraph::query
