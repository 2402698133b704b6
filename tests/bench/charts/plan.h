// How much the study of speed against accuracy measures.
#pragma once

#include <cstddef>

namespace sightline::bench {

struct ChartPlan {
  std::size_t rays = 20'000;            ///< Of each kind, through every builder's trees.
  std::size_t largest_image = 100'000;  ///< Rays of the largest picture that is traced.
  /// Larger pictures, up to this, are extrapolated from the cost of one more ray.
  std::size_t largest_extrapolated = 1'000'000;
};

/// Enough to see that all of it works.
inline constexpr ChartPlan kQuickChart{
    .rays = 300, .largest_image = 100, .largest_extrapolated = 1000};

}  // namespace sightline::bench
