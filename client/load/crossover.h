// Where one curve falls below another for good.
#pragma once

#include <optional>
#include <span>

namespace sightline::client::load {

struct Point {
  double x = 0;
  double y = 0;
};

/// The y of a curve, linear between its points, which have rising x. `x` must be within it.
double value_at(std::span<const Point> curve, double x);

/// The x from which on `rival` stays at or below `leader` times `within`, as far as both curves go.
/// Nothing if it is above at the end, or if the curves have no x in common.
std::optional<double> crossover(std::span<const Point> leader, std::span<const Point> rival,
                                double within = 1);

/// Times whose quotient is at most this count as the same: runs scatter by about that much.
inline constexpr double kSameTime = 1.05;

}  // namespace sightline::client::load
