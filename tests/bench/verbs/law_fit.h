// touches = a n + b m log2 m: the law of lazy building, fitted to counts.
#pragma once

#include <span>

namespace sightline::bench {

/// The cost of a tree over n triangles whose rays entered leaves with m of them.
struct LawPoint {
  double n = 0, m = 0;
  double touches = 0;  ///< Above 0.
};

struct LawFit {
  double a = 0, b = 0;
  /// 1 - sum (fit - y)^2 / sum (y - mean y)^2 over the touches y: large trees dominate.
  double r_squared = 0;
  /// The same over logarithms: all points have the same weight.
  double r_squared_log = 0;
  double max_residual = 0;  ///< max |fit - y| / y.

  double touches(double n, double m) const;
};

/// Least squares of (fit - y) / sqrt(y), with a and b not below 0. This lies between absolute
/// errors, where only large trees would count, and relative errors, where small windows would
/// dominate. Needs at least two points.
LawFit fit_law(std::span<const LawPoint> points);

}  // namespace sightline::bench
