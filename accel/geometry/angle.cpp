// Angles in double-doubles: halves of them until a short series is enough.
#include "accel/geometry/angle.h"

namespace sightline::accel::geometry {
namespace {

DoubleDouble root(const DoubleDouble& x) { return root_of_quotient(x, {1, 0}); }

/// For t of at most tan(pi / 32), whose square is below 2^-6.6.
DoubleDouble arc_tangent(const DoubleDouble& t) {
  constexpr int kTerms = 17;
  const DoubleDouble square = t * t;
  DoubleDouble sum;
  for (int i = kTerms - 1; i >= 0; --i)
    sum = DoubleDouble{1} / DoubleDouble{static_cast<double>(2 * i + 1)} - square * sum;
  return t * sum;
}

}  // namespace

DoubleDouble angle_of(const DoubleDouble& sine, const DoubleDouble& cosine) {
  const DoubleDouble one{1}, square = sine * sine + cosine * cosine;
  if (square.high == 0) return {};
  const bool obtuse = cosine.high < 0;
  // The tangent of half of the acute angle, and of a half of that, three times.
  DoubleDouble t = sine / (root(square) + (obtuse ? -cosine : cosine));
  for (int halving = 0; halving < 3; ++halving) t = t / (one + root(one + t * t));
  const DoubleDouble acute = arc_tangent(t) * DoubleDouble{16};
  return obtuse ? kPi - acute : acute;
}

}  // namespace sightline::accel::geometry
