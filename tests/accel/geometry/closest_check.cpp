// The distance rule by its definition: the least of three corners, three edges and the plane, in
// exact arithmetic.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "tests/accel/geometry/closest_cases.h"
#include "tests/support/rational.h"

namespace sightline::accel::geometry {
namespace {

using tests::Dyadic;
using tests::DyadicVec;

DyadicVec operator+(const DyadicVec& a, const DyadicVec& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
DyadicVec operator*(const DyadicVec& a, const Dyadic& s) { return {a[0] * s, a[1] * s, a[2] * s}; }

/// A point of the face, seen from p: at / whole, with the square of its length times whole^2.
struct Candidate {
  DyadicVec at;
  Dyadic whole;
  int feature = 0;  // 0 to 2: corner; 3 to 5: edge from corner i - 3; 6: inside
  Dyadic square() const { return dot(at, at); }
};

DyadicVec point_of(const ClosestCase& c) {
  const auto flushed = [](double x) { return std::fabs(x) < 0x1p-250 ? 0.0 : x; };
  return tests::exactly(Vec3d{flushed(c.p.x), flushed(c.p.y), flushed(c.p.z)});
}

DyadicVec corner_of(const ClosestCase& c, std::size_t i) {
  const DyadicVec v = tests::exactly(c.vertices[i]);
  DyadicVec result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* row = &c.matrix[4 * axis];
    result[axis] = dot({Dyadic(row[0]), Dyadic(row[1]), Dyadic(row[2])}, v) + Dyadic(row[3]);
  }
  return result;
}

std::vector<Candidate> candidates(const std::array<DyadicVec, 3>& r) {
  std::vector<Candidate> all;
  const Dyadic one(1.0);
  for (int i = 0; i < 3; ++i) all.push_back({r[static_cast<std::size_t>(i)], one, i});
  const DyadicVec normal = cross(r[1] - r[0], r[2] - r[0]);
  const Dyadic area = dot(normal, normal);
  bool inside = area.sign() > 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const DyadicVec &from = r[i], &to = r[(i + 1) % 3], edge = to - from;
    const Dyadic length = dot(edge, edge), begin = -dot(from, edge);
    if (length.sign() > 0 && begin.sign() > 0 && dot(to, edge).sign() > 0)
      all.push_back({from * length + edge * begin, length, static_cast<int>(i) + 3});
    inside = inside && dot(cross(edge, from), normal).sign() < 0;
  }
  if (inside) all.push_back({normal * dot(normal, r[0]), area, 6});
  return all;
}

bool nearer(const Candidate& a, const Candidate& b) {
  return (a.square() * (b.whole * b.whole) - b.square() * (a.whole * a.whole)).sign() < 0;
}

Candidate nearest(const ClosestCase& c) {
  const DyadicVec p = point_of(c);
  const auto all = candidates({corner_of(c, 0) - p, corner_of(c, 1) - p, corner_of(c, 2) - p});
  return *std::min_element(all.begin(), all.end(), nearer);
}

std::string weights_fault(const ClosestPoint& a, int feature) {
  if (!(a.u >= 0 && a.v >= 0 && a.u + a.v <= 1)) return "weights out of range";
  const bool right = feature == 0   ? a.u == 0 && a.v == 0
                     : feature == 1 ? a.u == 1 && a.v == 0
                     : feature == 2 ? a.u == 0 && a.v == 1
                     : feature == 3 ? a.v == 0
                     : feature == 4 ? a.v == 1 - a.u
                     : feature == 5 ? a.u == 0
                                    : true;
  return right ? "" : "weights of another feature than " + std::to_string(feature);
}

}  // namespace

bool is_rounded_distance(const ClosestCase& c, double d) {
  if (!(d >= 0) || std::signbit(d)) return false;
  const Candidate best = nearest(c);
  // Twice the ends of what rounds to d, compared by squares.
  constexpr double kLargest = std::numeric_limits<double>::max();
  const bool infinite = d > kLargest;
  const double finite = infinite ? kLargest : d;
  const double above = finite == kLargest ? 0x1p+971 : std::nextafter(d, 2 * kLargest) - d;
  const double below = d == 0 ? 0 : finite - std::nextafter(finite, 0);
  const Dyadic twice = Dyadic(finite) + Dyadic(finite);
  const Dyadic high = (twice + Dyadic(above)) * best.whole;
  const Dyadic low = infinite ? high : (twice - Dyadic(below)) * best.whole;
  const Dyadic square = best.square() * Dyadic(4);
  const int from_low = (square - low * low).sign(), from_high = (high * high - square).sign();
  const bool even = std::bit_cast<std::uint64_t>(d) % 2 == 0;
  if (infinite) return from_low >= 0;
  return (even ? from_low >= 0 : from_low > 0) && (even ? from_high >= 0 : from_high > 0);
}

std::string fault_of(const ClosestCase& c, const ClosestPoint& answer) {
  const Candidate best = nearest(c);
  const DyadicVec p = point_of(c), at = best.at + p * best.whole;
  double largest = 0, sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    largest = std::max(largest, std::fabs(c.p[axis]));
    for (std::size_t i = 0; i < 3; ++i) {
      const Dyadic x = corner_of(c, i)[axis];
      largest = std::max(largest, std::fabs(Dyadic::ratio(x, Dyadic(1.0))));
    }
  }
  if (!(largest < 0x1p+1022)) return "";
  const Dyadic ulp(std::nextafter(largest, 0x1p+1023) - largest);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(answer.position[axis])) return "a position that is not finite";
    const Dyadic off = (Dyadic(answer.position[axis]) * best.whole - at[axis]).magnitude();
    if ((off - ulp * best.whole * Dyadic(2)).sign() > 0) return "a position off by more than 2 ulp";
    const double x = std::fabs(answer.position[axis]);
    const Dyadic last_bit(std::nextafter(x, 0x1p+1023) - x);
    if (best.feature < 3 && (off + off - last_bit).sign() > 0) return "a corner not rounded once";
  }
  // The weights give the point, too, where it is not far off in the size of the face.
  const double w = 1 - answer.u - answer.v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const DyadicVec a = corner_of(c, 0), b = corner_of(c, 1), d = corner_of(c, 2);
    const Dyadic off =
        ((a[axis] * Dyadic(w) + b[axis] * Dyadic(answer.u) + d[axis] * Dyadic(answer.v)) *
             best.whole -
         at[axis])
            .magnitude();
    sum = std::max(sum, Dyadic::ratio(off, best.whole));
  }
  if (sum > 0x1p-30 * largest) return "weights off by " + std::to_string(sum / largest);
  return weights_fault(answer, best.feature);
}

}  // namespace sightline::accel::geometry
