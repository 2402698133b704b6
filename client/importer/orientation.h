// On which side of a line a point lies, exactly. Internal to the importer.
#pragma once

#include <cmath>

namespace sightline::client::importer {

/// A point whose coordinates are floats, so that products are exact.
struct PlanePoint {
  double x = 0, y = 0;

  friend bool operator==(const PlanePoint&, const PlanePoint&) = default;
};

/// The sign of a sum of six products of floats; slow.
int exact_orientation(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c);

/// Above 0: a, b, c turn to the left; below 0: to the right; 0: they lie on a line.
inline int orientation(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
  const double difference = left - right;
  // Shewchuk's bound for this expression, rounded up
  const double bound = 4e-16 * (std::abs(left) + std::abs(right));
  if (std::abs(difference) > bound) return difference > 0 ? 1 : -1;
  if (bound == 0) return 0;  // A factor of each product is zero: those of floats do not underflow.
  return exact_orientation(a, b, c);
}

}  // namespace sightline::client::importer
