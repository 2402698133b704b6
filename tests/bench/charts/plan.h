// How much the study of speed against accuracy measures.
#pragma once

#include <cstddef>

namespace sightline::bench {

struct ChartPlan {
  std::size_t rays = 60'000;              ///< Rays of each kind, through every builder's trees.
  std::size_t largest_image = 1'000'000;  ///< Number of rays of the largest picture that is traced.
  /// Number of rays of the largest picture whose time is extrapolated from the cost of a ray.
  std::size_t largest_extrapolated = 10'000'000;
  std::size_t aimed_rays = 40'000;  ///< Rays of each family, a quarter of each kind.
  int sphere_level = 5;             ///< Level of the families' spheres: 20 * 4^level triangles.
};

/// A minimal plan that runs every part.
inline constexpr ChartPlan kQuickChart{.rays = 300,
                                       .largest_image = 100,
                                       .largest_extrapolated = 1000,
                                       .aimed_rays = 400,
                                       .sphere_level = 2};

}  // namespace sightline::bench
