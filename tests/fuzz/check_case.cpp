// Checks the intersector against the exact reference on one ray and its patch of triangles.
#include "tests/fuzz/check_case.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "accel/geometry/facing.h"
#include "accel/geometry/intersect.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_prefilter.h"
#include "tests/fuzz/expected_sum.h"

namespace sightline::tests {

using accel::geometry::Barycentric;
using accel::geometry::LocalRay;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

constexpr std::size_t kFindingsKept = 5;
constexpr double kNear = 1e-6;

/// During its lifetime, denormal results are zero in this thread.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  explicit FlushDenormals(bool flush) : before_(_mm_getcsr()) {
    if (flush) _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON);
  }
  ~FlushDenormals() { _mm_setcsr(before_); }
#else
  explicit FlushDenormals(bool /*flush*/) {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

#if defined(__SSE2__)
 private:
  unsigned before_;
#endif
};

std::string in_hex(const Vec3d& v) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "{%a, %a, %a}", v.x, v.y, v.z);
  return text.data();
}

void report(Tally& tally, const std::string& what, const LocalRay& ray, const HardCase& hard) {
  if (tally.findings.size() >= kFindingsKept) return;
  std::string text =
      what + "\n  origin " + in_hex(ray.origin) + " direction " + in_hex(ray.direction);
  for (std::size_t i = 0; i < hard.vertex_count; ++i) {
    text += "\n  vertex " + std::to_string(i) + " " + in_hex(Vec3d(hard.vertex[i]));
  }
  for (const accel::geometry::Face& f : hard.faces()) {
    text += "\n  face " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " +
            std::to_string(f[2]);
  }
  tally.findings.push_back(text);
}

/// The part of v - o across the ray, in double: accurate to a few roundings of |v - o|.
Vec3d across(const LocalRay& ray, const Vec3d& v) {
  const Vec3d p = v - ray.origin;
  return p - ray.direction * (dot(p, ray.direction) / dot(ray.direction, ray.direction));
}

bool passes_near_edge(const LocalRay& ray, const std::array<Vec3f, 3>& v) {
  std::array<Vec3d, 3> seen;
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    seen[i] = across(ray, Vec3d(v[i]));
    size = std::max(size, length(Vec3d(v[(i + 1) % 3]) - Vec3d(v[i])));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d p = seen[i], along = seen[(i + 1) % 3] - p;
    const double square = dot(along, along);
    const double s = square > 0 ? std::clamp(-dot(p, along) / square, 0.0, 1.0) : 0;
    if (length(p + along * s) <= kNear * size) return true;
  }
  return false;
}

class Check {
 public:
  Check(const HardCase& hard, const Asking& asking, const LocalRay& ray, Tally& tally)
      : hard_(hard),
        asking_(asking),
        ray_(ray),
        exact_ray_(ray.origin, ray.direction),
        tally_(tally),
        count_(tally.by_patch[static_cast<std::size_t>(hard.patch)]) {
    for (std::size_t i = 0; i < hard.vertex_count; ++i) exact_[i] = exactly(hard.vertex[i]);
    std::copy(hard.vertex.begin(), hard.vertex.end(), vertices_.begin());
  }

  void patch() {
    int sum = 0;
    for (const accel::geometry::Face& f : hard_.faces()) sum += triangle(f) ? 1 : 0;
    const ExpectedSum expected = expected_sum(exact_ray_, hard_, exact_);
    const bool one = expected == ExpectedSum::kOne, folded = expected == ExpectedSum::kNoneOrTwo;
    count_.one += one ? 1 : 0;
    count_.folded += folded ? 1 : 0;
    if ((one && sum != 1) || (folded && sum != 0 && sum != 2)) {
      ++count_.wrong_sums;
      report(tally_, std::to_string(sum) + (one ? " owners, not one" : " hits, not 0 or 2"), ray_,
             hard_);
    }
  }

 private:
  /// Whether the intersector hits it.
  bool triangle(const accel::geometry::Face& face) {
    const DyadicVec &a = exact_[face[0]], &b = exact_[face[1]], &c = exact_[face[2]];
    const RationalHit expected = judge(exact_ray_, a, b, c);
    ++count_.pairs;
    count_.near += passes_near_edge(ray_, corners(face)) ? 1 : 0;
    count_.hits += expected.hit ? 1 : 0;
    count_.zeros += expected.zeros > 0 ? 1 : 0;

    const bool hit = ask(face, expected.hit);
    if (asking_.all_orders) {
      for (const std::array<std::size_t, 3> order :
           {std::array<std::size_t, 3>{1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}) {
        ask({face[order[0]], face[order[1]], face[order[2]]}, expected.hit);
      }
    }
    return hit;
  }

  bool ask(const accel::geometry::Face& face, bool expected) {
    const auto [a, b, c] = corners(face);
    std::optional<double> t;
    Barycentric weights;
    int facing = 0;
    bool possible = false;
    {
      const FlushDenormals flush(asking_.flush_denormals);
      t = accel::geometry::intersect(ray_, a, b, c);
      if (t) weights = accel::geometry::barycentric(ray_, *t, a, b, c);
      facing = accel::geometry::facing(ray_, a, b, c);
      const std::uint32_t first = 0;
      possible = accel::geometry::candidate_mask({vertices_, {&face, 1}},
                                                 accel::geometry::sheared(ray_), {&first, 1});
    }
    if (expected && !possible) {
      ++count_.wrong_misses;
      found("taken for a certain miss", face);
    }
    if (t.has_value() != expected) {
      ++count_.wrong_hits;
      found(expected ? "missed" : "hit by mistake", face);
    } else if (t) {
      check_meeting(face, *t, weights);
    }
    if (facing != exact_ray_.facing(exact_[face[0]], exact_[face[1]], exact_[face[2]])) {
      ++count_.wrong_facing;
      found("facing " + std::to_string(facing), face);
    }
    return t.has_value();
  }

  void check_meeting(const accel::geometry::Face& face, double t, const Barycentric& weights) {
    const auto [u, v] = weights;
    // The reference does not accept non-finite numbers.
    double t_error = accel::geometry::kInfinity, point_error = accel::geometry::kInfinity;
    const RationalMeeting meeting(exact_ray_, exact_[face[0]], exact_[face[1]], exact_[face[2]]);
    if (std::isfinite(t)) t_error = meeting.t_error(t);
    if (u >= 0 && v >= 0 && u + v <= 1) point_error = meeting.point_error(u, v);
    tally_.largest_t_error = std::max(tally_.largest_t_error, t_error);
    tally_.largest_point_error = std::max(tally_.largest_point_error, point_error);
    if (t_error > accel::geometry::kHitError) {
      ++count_.wrong_t;
      found("t off by " + std::to_string(t_error / accel::geometry::kHitError) + " kHitError",
            face);
    }
    if (point_error > 16 * accel::geometry::kHitError) {
      ++count_.wrong_weights;
      found("weights " + std::to_string(u) + " " + std::to_string(v) + " name a point off by " +
                std::to_string(point_error / accel::geometry::kHitError) + " kHitError",
            face);
    }
  }

  std::array<Vec3f, 3> corners(const accel::geometry::Face& f) const {
    return {hard_.vertex[f[0]], hard_.vertex[f[1]], hard_.vertex[f[2]]};
  }
  void found(const std::string& what, const accel::geometry::Face& f) {
    report(tally_,
           what + ": triangle " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " +
               std::to_string(f[2]),
           ray_, hard_);
  }

  const HardCase& hard_;
  const Asking& asking_;
  const LocalRay& ray_;
  RationalRay exact_ray_;
  Tally& tally_;
  PairCount& count_;
  ExactVertices exact_;
  std::array<Vec3f, HardCase::kMaxVertices + 1> vertices_{};  ///< No face uses the last one.
};

}  // namespace

void PairCount::add(const PairCount& other) {
  pairs += other.pairs;
  near += other.near;
  hits += other.hits;
  zeros += other.zeros;
  one += other.one;
  folded += other.folded;
  wrong_hits += other.wrong_hits;
  wrong_misses += other.wrong_misses;
  wrong_t += other.wrong_t;
  wrong_weights += other.wrong_weights;
  wrong_facing += other.wrong_facing;
  wrong_sums += other.wrong_sums;
}

void Tally::add(const Tally& other) {
  for (std::size_t i = 0; i < kPatches; ++i) by_patch[i].add(other.by_patch[i]);
  largest_t_error = std::max(largest_t_error, other.largest_t_error);
  largest_point_error = std::max(largest_point_error, other.largest_point_error);
  for (const std::string& finding : other.findings) {
    if (findings.size() < kFindingsKept) findings.push_back(finding);
  }
}

PairCount Tally::total() const {
  PairCount sum;
  for (const PairCount& count : by_patch) sum.add(count);
  return sum;
}

void check(const HardCase& hard, const Asking& asking, Tally& tally) {
  const std::optional<LocalRay> ray = accel::geometry::make_local_ray(hard.origin, hard.direction);
  if (ray) Check(hard, asking, *ray, tally).patch();
}

}  // namespace sightline::tests
