// Cuts off one ear after another, in a projection along an axis.
//
// Why the triangles cover the polygon once: each cut replaces two edges by one, so the winding
// numbers of the triangles and of what is left always add up to that of the polygon. A polygon
// without self-intersection has winding number 1 inside and 0 outside. So triangles that all turn
// as the polygon does cover every point as often as they should. Where no cut is left that keeps
// this, the polygon intersects itself in this projection.
#include "client/importer/triangulate.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "client/importer/crossings.h"
#include "client/importer/finite.h"
#include "client/importer/orientation.h"
#include "client/importer/point_tree.h"

namespace sightline::client::importer {
namespace {

using Corner = std::uint32_t;  // by its number in the polygon

// An axis other than that of the largest part of the normal must have this share of it.
constexpr double kLeastPart = 0.1;

// How far the lines through float vertices lie from those of the file, as a share of the largest
// coordinate.
constexpr double kRounding = 0x1p-21;

// A polygon that touches itself at one place thousands of times would take quadratic time.
constexpr std::size_t kMostLooks = 1000;  // looks at other corners, for each corner of the polygon

double largest_coordinate(const std::vector<Vertex>& vertices,
                          std::span<const std::uint32_t> corners) {
  float largest = 0;
  for (const std::uint32_t corner : corners) {
    for (const float x : vertices[corner]) largest = std::max(largest, std::abs(x));
  }
  return static_cast<double>(largest);
}

// Newell's normal of a polygon.
std::array<double, 3> normal_of(const std::vector<Vertex>& vertices,
                                std::span<const std::uint32_t> corners) {
  std::array<double, 3> normal{};
  const auto from_first = [&](std::size_t i, std::size_t axis) {
    return static_cast<double>(vertices[corners[i]][axis]) -
           static_cast<double>(vertices[corners[0]][axis]);
  };
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
      normal[k] +=
          from_first(i, u) * from_first(i + 1, v) - from_first(i, v) * from_first(i + 1, u);
    }
  }
  return normal;
}

// Twice the area of triangles, each of three of the corners.
double area_of(const std::vector<Vertex>& vertices, std::span<const std::uint32_t> corners,
               const std::vector<std::array<Corner, 3>>& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    const std::array<double, 3> normal =
        normal_of(vertices, std::array{corners[a], corners[b], corners[c]});
    sum += std::hypot(normal[0], normal[1], normal[2]);
  }
  return sum;
}

// The order along a line, from left to right.
bool is_before(const PlanePoint& a, const PlanePoint& b) {
  return a.x < b.x || (a.x == b.x && a.y < b.y);
}

}  // namespace

// A polygon in the plane.
class Triangulator::Work {
 public:
  enum class Outcome {
    kCovered,
    kFlat,   // All corners are on a line.
    kStuck,  // It intersects itself.
  };

  void begin(std::size_t corners) { looks_left_ = kMostLooks * corners; }
  bool gave_up() const { return looks_left_ == 0; }

  void project(const std::vector<Vertex>& vertices, std::span<const std::uint32_t> corners,
               std::size_t axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    points_.clear();
    for (const std::uint32_t corner : corners) {
      points_.push_back(
          {static_cast<double>(vertices[corner][u]), static_cast<double>(vertices[corner][v])});
    }
  }

  // The corner of a convex polygon, or of one with four corners, from which a fan covers it.
  std::optional<std::size_t> fan() const {
    const std::size_t n = points_.size();
    std::size_t left = 0, right = 0, last_left = 0, last_right = 0, reversals = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const PlanePoint &a = points_[(i + n - 1) % n], &b = points_[i], &c = points_[(i + 1) % n];
      const int turn = orientation(a, b, c);
      if (turn > 0) ++left, last_left = i;
      if (turn < 0) ++right, last_right = i;
      if (is_before(a, b) != is_before(b, c)) ++reversals;
    }
    if (n == 4 && left == 3 && right == 1) return last_right;
    if (n == 4 && left == 1 && right == 3) return last_left;
    if (reversals != 2 || (left > 0) == (right > 0)) return {};
    for (std::size_t first = 0; first < 3; ++first) {
      if (is_fan(first, left > 0 ? 1 : -1)) return first;
    }
    return {};
  }

  // Cuts the polygon, or as much of it as can be cut rightly.
  Outcome cut() {
    start();
    for (Corner corner = 0; corner < points_.size(); ++corner) cut_spikes_at(corner);
    if (left_ < 3) return Outcome::kFlat;
    if (turn_of_polygon() < 0) {
      for (PlanePoint& point : points_) point.x = -point.x;
    }
    keep_reflex_corners();
    for (const bool is_strict : {true, false}) {
      push_all();
      cut_ears(is_strict);
      if (left_ < 3) return Outcome::kCovered;
    }
    return Outcome::kStuck;
  }

  // Cuts what is left, at any corner if need be. The queue has all of them, and again each one
  // whose neighbor was cut off, so that one look at each entry finds every convex corner.
  void cut_rest() {
    for (std::size_t looked_at = 0; left_ >= 3; cut_ears(false)) {
      const auto is_convex = [&](Corner corner) { return is_left_[corner] && turn_at(corner) > 0; };
      while (looked_at < queue_.size() && !is_convex(queue_[looked_at])) ++looked_at;
      cut_off(looked_at < queue_.size() ? queue_[looked_at] : any_);
    }
  }

  // Whether edges cross, or a triangle turns the other way than the polygon, by more than this
  // length.
  bool crosses_itself(double least) const {
    const auto turns_back = [&](const std::array<Corner, 3>& triangle) {
      const PlanePoint &a = at(triangle[0]), &b = at(triangle[1]), &c = at(triangle[2]);
      const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      const double length = std::hypot(b.x - a.x, b.y - a.y) + std::hypot(c.x - a.x, c.y - a.y);
      return area < -least * length;
    };
    return std::any_of(triangles_.begin(), triangles_.end(), turns_back) ||
           has_crossing(points_, least);
  }
  const std::vector<std::array<Corner, 3>>& triangles() const { return triangles_; }

 private:
  bool is_fan(std::size_t first, int turn) const {
    const std::size_t n = points_.size();
    for (std::size_t k = 2; k < n; ++k) {
      const PlanePoint &b = points_[(first + k - 1) % n], &c = points_[(first + k) % n];
      if (orientation(points_[first], b, c) != turn) return false;
    }
    return true;
  }

  void start() {
    const std::size_t n = points_.size();
    triangles_.clear();
    queue_.clear();
    head_ = 0;
    left_ = n;
    any_ = 0;
    tree_.build(points_, {});
    position_.assign(n, 0);
    is_left_.assign(n, true);
    previous_.resize(n);
    next_.resize(n);
    for (Corner i = 0; i < n; ++i) {
      previous_[i] = static_cast<Corner>(i == 0 ? n - 1 : i - 1);
      next_[i] = static_cast<Corner>(i + 1 == n ? 0 : i + 1);
    }
  }

  const PlanePoint& at(Corner corner) const { return points_[corner]; }
  int turn(Corner a, Corner b, Corner c) const { return orientation(at(a), at(b), at(c)); }
  int turn_at(Corner corner) const { return turn(previous_[corner], corner, next_[corner]); }

  // Whether nothing lies between the edges of this corner: one has no length, or they go the same
  // way.
  bool is_spike(Corner b) const {
    const PlanePoint &to = at(previous_[b]), &from = at(next_[b]);
    if (to == at(b) || from == at(b)) return true;
    return turn_at(b) == 0 && is_before(to, at(b)) == is_before(from, at(b));
  }

  void cut_off(Corner b) {
    const Corner a = previous_[b], c = next_[b];
    triangles_.push_back({a, b, c});
    next_[a] = c;
    previous_[c] = a;
    is_left_[b] = false;
    tree_.remove(b);
    any_ = c;
    --left_;
    for (const Corner corner : {a, c}) {
      if (turn_at(corner) > 0) tree_.remove(corner);
      push(corner);
    }
  }

  void cut_spikes_at(Corner corner) {
    while (left_ >= 3 && is_left_[corner] && is_spike(corner)) {
      const Corner before = previous_[corner];
      cut_off(corner);
      corner = is_spike(before) ? before : next_[before];
    }
  }

  // The first corner of all from left to right is convex, as there are no spikes.
  int turn_of_polygon() const {
    Corner first = any_;
    for (Corner corner = next_[any_]; corner != any_; corner = next_[corner]) {
      if (is_before(at(corner), at(first))) first = corner;
    }
    return turn_at(first);
  }

  void keep_reflex_corners() {
    std::vector<Corner> reflex;
    for (Corner corner = 0; corner < points_.size(); ++corner) {
      if (is_left_[corner] && turn_at(corner) <= 0) reflex.push_back(corner);
    }
    tree_.build(points_, std::move(reflex));
  }

  void push(Corner corner) {
    queue_.push_back(corner);
    position_[corner] = queue_.size();
  }

  void push_all() {
    queue_.clear();
    head_ = 0;
    for (Corner corner = 0; corner < points_.size(); ++corner) {
      if (is_left_[corner]) push(corner);
    }
  }

  // A corner that is no ear stays none until one of its neighbors is cut off. It is looked at
  // where it was put last: triangles are less thin if those side by side are not cut off in turn.
  void cut_ears(bool is_strict) {
    while (left_ >= 3 && head_ < queue_.size()) {
      const Corner corner = queue_[head_++];
      if (position_[corner] != head_ || !is_left_[corner]) continue;
      if (is_spike(corner) || is_ear(corner, is_strict)) cut_off(corner);
    }
  }

  // Whether the edge from the previous to the next corner lies inside of the polygon.
  bool is_ear(Corner b, bool is_strict) {
    const Corner a = previous_[b], c = next_[b];
    if (turn(a, b, c) <= 0) return false;
    if (turn_at(a) > 0 && turn(previous_[a], a, c) < 0) return false;
    if (turn_at(c) > 0 && turn(a, c, next_[c]) < 0) return false;
    // If any corner is in the triangle, one that is not convex is there.
    return !tree_.any(at(a), at(b), at(c), [&](Corner other) {
      if (looks_left_ == 0) return true;
      --looks_left_;
      return other != a && other != b && other != c && is_in_way(other, {a, b, c}, is_strict);
    });
  }

  // Whether the boundary at corner `v` is in the way of the triangle a, b, c. Boundaries that only
  // touch the triangle are not, except at the new edge, where they would lie on an edge later.
  bool is_in_way(Corner v, const std::array<Corner, 3>& triangle, bool is_strict) const {
    const auto [a, b, c] = triangle;
    if (at(v) == at(a) || at(v) == at(c)) return false;
    const int of_ab = turn(a, b, v), of_bc = turn(b, c, v), of_ca = turn(c, a, v);
    if (of_ab < 0 || of_bc < 0 || of_ca < 0) return false;
    if (of_ca == 0 && is_strict) return true;
    for (const Corner to : {previous_[v], next_[v]}) {
      if ((of_ab > 0 || turn(a, b, to) > 0) && (of_bc > 0 || turn(b, c, to) > 0) &&
          (of_ca > 0 || turn(c, a, to) > 0))
        return true;
    }
    return false;
  }

  std::vector<PlanePoint> points_;  // by corner, as are the next four
  std::vector<Corner> previous_, next_;
  std::vector<std::size_t> position_;  // where it was last put in the queue, from 1 on
  std::vector<bool> is_left_;
  std::vector<Corner> queue_;
  std::size_t head_ = 0;
  std::size_t left_ = 0;
  std::size_t looks_left_ = 0;
  Corner any_ = 0;  // one that is left
  PointTree tree_;  // the corners that are not convex
  std::vector<std::array<Corner, 3>> triangles_;
};

Triangulator::Triangulator(const std::vector<Vertex>& vertices)
    : vertices_(vertices), work_(std::make_unique<Work>()) {}

Triangulator::~Triangulator() = default;

bool Triangulator::cut(std::span<const std::uint32_t> corners, std::vector<Face>& faces) {
  const std::size_t n = corners.size();
  const auto add_fan = [&](std::size_t first) {
    for (std::size_t k = 2; k < n; ++k) {
      faces.push_back({corners[first], corners[(first + k - 1) % n], corners[(first + k) % n]});
    }
    return true;
  };
  const auto add_triangles = [&] {
    assert(work_->triangles().size() == n - 2);
    for (const auto& [a, b, c] : work_->triangles())
      faces.push_back({corners[a], corners[b], corners[c]});
  };
  if (n == 3) return add_fan(0);
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_finite(vertices_[corners[i]])) return add_fan(i);
  }
  const std::array<double, 3> normal = normal_of(vertices_, corners);
  const auto part = [&](std::size_t axis) { return std::abs(normal[axis]); };
  std::array<std::size_t, 3> axes{2, 1, 0};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return part(a) > part(b); });
  const double least = kRounding * largest_coordinate(vertices_, corners);
  std::optional<std::size_t> stuck;
  work_->begin(n);
  std::size_t flattest = axes[0];
  double least_area = HUGE_VAL;
  for (const std::size_t axis : axes) {
    if (part(axis) < kLeastPart * part(axes[0])) break;
    work_->project(vertices_, corners, axis);
    if (const auto first = work_->fan()) return add_fan(*first);
    const Work::Outcome outcome = work_->cut();
    if (outcome == Work::Outcome::kStuck && !stuck) stuck = axis;
    if (outcome == Work::Outcome::kFlat) {
      const double area = area_of(vertices_, corners, work_->triangles());
      if (area < least_area) least_area = area, flattest = axis;
    }
    if (outcome != Work::Outcome::kCovered) continue;
    add_triangles();
    return !work_->crosses_itself(least);
  }
  // A polygon without area is cut where its triangles have the least, which is none.
  work_->project(vertices_, corners, stuck.value_or(flattest));
  work_->cut();
  work_->cut_rest();
  add_triangles();
  return !work_->gave_up() && !work_->crosses_itself(least);
}

}  // namespace sightline::client::importer
