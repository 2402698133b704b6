// How much the study of speed against accuracy measures.
#pragma once

#include <cstddef>

namespace sightline::bench {

struct ChartPlan {
  std::size_t rays = 60'000;              ///< Of each kind, through every builder's trees.
  std::size_t largest_image = 1'000'000;  ///< Rays of the largest picture that is traced.
  std::size_t largest_told = 10'000'000;  ///< Beyond that: told from what one more ray costs.
  std::size_t aimed_rays = 40'000;        ///< A family, a quarter of each kind.
  int sphere_level = 5;                   ///< Of the families' spheres: 20 * 4^level triangles.
};

/// Enough to see that all of it works.
inline constexpr ChartPlan kQuickChart{
    .rays = 300, .largest_image = 100, .largest_told = 1000, .aimed_rays = 400, .sphere_level = 2};

}  // namespace sightline::bench
