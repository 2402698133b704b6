// Compares boxes around ranges of edges with each other, and then edges.
#include "client/importer/crossings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace sightline::client::importer {
namespace {

constexpr std::uint64_t kMostComparisons = 50'000'000;  // comparisons of boxes; about half a second
constexpr std::size_t kLeaf = 4;                        // as many edges, or fewer

// Whether a point is farther than this from the line through a and b.
bool is_off(const PlanePoint& p, const PlanePoint& a, const PlanePoint& b, double distance) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  return std::abs(dx * (p.y - a.y) - dy * (p.x - a.x)) > distance * std::hypot(dx, dy);
}

bool cross(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c, const PlanePoint& d,
           double least) {
  return orientation(a, b, c) * orientation(a, b, d) < 0 &&
         orientation(c, d, a) * orientation(c, d, b) < 0 && is_off(a, c, d, least) &&
         is_off(b, c, d, least) && is_off(c, a, b, least) && is_off(d, a, b, least);
}

struct Box {
  PlanePoint lo, hi;
};

class Edges {
 public:
  Edges(std::span<const PlanePoint> polygon, double least) : polygon_(polygon), least_(least) {
    while (leaves_ * kLeaf < polygon.size()) leaves_ *= 2;
    boxes_.resize(2 * leaves_);
    for (std::size_t i = boxes_.size(); i-- > 1;) boxes_[i] = i < leaves_ ? around(i) : of_leaf(i);
  }

  bool any_cross() const {
    std::vector<std::pair<std::size_t, std::size_t>> open{{1, 1}};
    for (std::uint64_t count = 0; !open.empty() && count < kMostComparisons; ++count) {
      const auto [a, b] = open.back();
      open.pop_back();
      if (are_separate(boxes_[a], boxes_[b])) continue;
      if (a >= leaves_) {
        if (any_cross(a, b)) return true;
      } else if (a == b) {
        open.insert(open.end(), {{2 * a, 2 * a}, {2 * a, 2 * a + 1}, {2 * a + 1, 2 * a + 1}});
      } else {
        for (const std::size_t k : {0U, 1U, 2U, 3U})
          open.emplace_back(2 * a + k / 2, 2 * b + k % 2);
      }
    }
    return false;
  }

 private:
  // Its children are boxes 2 i and 2 i + 1.
  Box around(std::size_t i) const {
    const Box &a = boxes_[2 * i], &b = boxes_[2 * i + 1];
    return {{std::min(a.lo.x, b.lo.x), std::min(a.lo.y, b.lo.y)},
            {std::max(a.hi.x, b.hi.x), std::max(a.hi.y, b.hi.y)}};
  }

  std::size_t first_of(std::size_t leaf) const {
    return std::min((leaf - leaves_) * kLeaf, polygon_.size());
  }
  const PlanePoint& end_of(std::size_t edge) const {
    return polygon_[edge + 1 < polygon_.size() ? edge + 1 : 0];
  }

  // An empty leaf has a box at the first point.
  Box of_leaf(std::size_t leaf) const {
    const std::size_t first = first_of(leaf), end = std::min(first + kLeaf, polygon_.size());
    const PlanePoint& at = polygon_[first < polygon_.size() ? first : 0];
    Box box{at, at};
    for (std::size_t i = first; i < end; ++i) {
      const PlanePoint &a = polygon_[i], &b = end_of(i);
      box.lo = {std::min({box.lo.x, a.x, b.x}), std::min({box.lo.y, a.y, b.y})};
      box.hi = {std::max({box.hi.x, a.x, b.x}), std::max({box.hi.y, a.y, b.y})};
    }
    return box;
  }

  static bool are_separate(const Box& a, const Box& b) {
    return a.hi.x < b.lo.x || b.hi.x < a.lo.x || a.hi.y < b.lo.y || b.hi.y < a.lo.y;
  }

  bool any_cross(std::size_t leaf, std::size_t other) const {
    const std::size_t end = std::min(first_of(leaf) + kLeaf, polygon_.size());
    const std::size_t other_end = std::min(first_of(other) + kLeaf, polygon_.size());
    for (std::size_t i = first_of(leaf); i < end; ++i) {
      for (std::size_t k = leaf == other ? i + 1 : first_of(other); k < other_end; ++k) {
        if (cross(polygon_[i], end_of(i), polygon_[k], end_of(k), least_)) return true;
      }
    }
    return false;
  }

  std::span<const PlanePoint> polygon_;
  double least_;
  std::size_t leaves_ = 1;
  std::vector<Box> boxes_;  // from 1 on; the leaves at the end
};

}  // namespace

bool has_crossing(std::span<const PlanePoint> polygon, double least) {
  return Edges(polygon, least).any_cross();
}

}  // namespace sightline::client::importer
