// Compact windows of parallel rays over a scene, and the cost of the fresh tree that they grow.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// A square in x and z, or the whole footprint's rectangle. Rays go straight down (-y) through it,
/// on a raster.
struct LawWindow {
  double lo_x = 0, lo_z = 0, hi_x = 0, hi_z = 0;
  double above = 0;  ///< Start of the rays, in y.
  std::size_t rays_x = 1, rays_z = 1;

  std::size_t rays() const { return rays_x * rays_z; }
  accel::geometry::Ray ray(std::size_t i) const;  ///< Row by row; i < rays().
};

/// At least this many rays a triangle, if triangles are evenly spread over the footprint.
inline constexpr double kLawRaysPerTriangle = 4;

/// `count` windows that each have `share` of the scene's footprint, lie within it, and contain a
/// random point of the surface; a share of 1 gives the one window there is. The seed determines
/// them.
std::vector<LawWindow> law_windows(const SceneGeometry& geometry, const AreaSampler& surface,
                                   double share, std::size_t count, std::uint64_t seed);

/// The mesh and the parameters that trees grow from.
struct LawTrees {
  const SceneSource* scene = nullptr;
  accel::published::AnyBuilder builder;
  accel::mesh::References references = accel::mesh::References::kRuns;
};

struct LawCount {
  std::uint64_t m = 0;  ///< Distinct triangles in leaves that rays entered up to their hits.
  std::uint64_t touches = 0, touches_prepare = 0, cells_expanded = 0;
  std::uint64_t rays = 0;
};

/// Grows fresh trees with the window's rays, first-touch, on the calling thread only: the counts
/// are the same every time.
Result<LawCount> count_window(const LawTrees& trees, const LawWindow& window);

/// As count_window, for unrelated rays; m stays 0.
Result<LawCount> count_scattered(const LawTrees& trees, const SceneGeometry& geometry,
                                 std::size_t rays, std::uint64_t seed);

/// The median of each count.
LawCount median_count(const std::vector<LawCount>& counts);

}  // namespace sightline::bench
