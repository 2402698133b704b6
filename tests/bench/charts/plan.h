// How much the study of speed against accuracy measures.
#pragma once

#include <cstddef>

namespace sightline::bench {

struct ChartPlan {
  std::size_t rays = 20'000;            ///< Rays of each kind, through every builder's trees.
  std::size_t largest_image = 100'000;  ///< Number of rays of the largest picture that is traced.
  /// Number of rays of the largest picture whose time is extrapolated from the cost of a ray.
  std::size_t largest_extrapolated = 1'000'000;
};

/// A minimal plan that runs every part.
inline constexpr ChartPlan kQuickChart{
    .rays = 300, .largest_image = 100, .largest_extrapolated = 1000};

}  // namespace sightline::bench
