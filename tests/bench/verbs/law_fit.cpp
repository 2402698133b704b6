// touches = a n + b m log2 m, fitted.
#include "tests/bench/verbs/law_fit.h"

#include <algorithm>
#include <cmath>

namespace sightline::bench {
namespace {

double m_log_m(double m) { return m > 1 ? m * std::log2(m) : 0; }

// Sums over the points, each weighted by 1 / y: of products of n and m log2 m, and of each with y.
struct NormalEquations {
  double nn = 0, nm = 0, mm = 0, ny = 0, my = 0;
};

NormalEquations normal_equations(std::span<const LawPoint> points) {
  NormalEquations e;
  for (const LawPoint& p : points) {
    const double n = p.n, m = m_log_m(p.m);
    e.nn += n * n / p.touches;
    e.nm += n * m / p.touches;
    e.mm += m * m / p.touches;
    e.ny += n;
    e.my += m;
  }
  return e;
}

// The share of the variance of y = f(touches) that the fit explains.
template <class F>
double r_squared(std::span<const LawPoint> points, const LawFit& fit, const F& f) {
  double mean = 0, left = 0, all = 0;
  for (const LawPoint& p : points) mean += f(p.touches);
  mean /= static_cast<double>(points.size());
  for (const LawPoint& p : points) {
    const double y = f(p.touches), error = f(fit.touches(p.n, p.m)) - y;
    left += error * error;
    all += (y - mean) * (y - mean);
  }
  return all > 0 ? 1 - left / all : 1;
}

}  // namespace

double LawFit::touches(double n, double m) const { return a * n + b * m_log_m(m); }

LawFit fit_law(std::span<const LawPoint> points) {
  const NormalEquations e = normal_equations(points);
  LawFit fit;
  const double determinant = e.nn * e.mm - e.nm * e.nm;
  if (determinant > 0) {
    fit.a = (e.ny * e.mm - e.my * e.nm) / determinant;
    fit.b = (e.my * e.nn - e.ny * e.nm) / determinant;
  }
  // Then a single term is the best fit; also with one column of zeros.
  if (!(determinant > 0) || fit.b < 0) {
    fit.a = e.nn > 0 ? e.ny / e.nn : 0;
    fit.b = 0;
  } else if (fit.a < 0) {
    fit.a = 0;
    fit.b = e.mm > 0 ? e.my / e.mm : 0;
  }
  for (const LawPoint& p : points) {
    const double error = std::abs(fit.touches(p.n, p.m) - p.touches) / p.touches;
    fit.max_residual = std::max(fit.max_residual, error);
  }
  fit.r_squared = r_squared(points, fit, [](double y) { return y; });
  fit.r_squared_log =
      r_squared(points, fit, [](double y) { return std::log(std::max(y, 1e-300)); });
  return fit;
}

}  // namespace sightline::bench
