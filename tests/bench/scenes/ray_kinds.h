// The rays of the measurements: seed, scene and kind determine them on every machine.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

enum class RayKind : std::uint8_t { kOverview, kCloseup, kDiffuse, kShadow, kRandom, kAimed };

/// Errors: kInvalidArgument, listing the kinds.
Result<RayKind> parse_ray_kind(std::string_view name);

/// `count` rays; diag is the diagonal of the scene's box, and y is up. Directions are unit vectors
/// unless the kind says otherwise.
/// overview: pinhole at center + 1.2 diag (1, 0.7, 0.5)/|.|, looking at the center, 40 degrees, in
/// 8x8 tiles.
/// closeup: pinhole 0.05 diag along the normal of an area-weighted random surface point, looking at
/// it, 40 degrees, redrawn until at most 1 % of the triangles are hit (after kMostRedraws: the draw
/// that hits fewest).
/// diffuse: one cosine bounce per overview hit, tmin 1e-6 diag, shuffled.
/// shadow: from overview hits to a light diag above the scene; direction of full length, tmin 1e-4,
/// tmax 1 - 1e-4.
/// random: chords of the bounding sphere that meet the box.
/// aimed: at vertices and at points on edges, half each, from a sphere of radius diag.
/// Traces on trees of its own; does not change the given scene.
/// Errors: kFailedPrecondition: the scene has no triangles, or no overview ray hits.
Result<std::vector<accel::geometry::Ray>> make_rays(const SceneSource& scene, RayKind kind,
                                                    std::size_t count, std::uint64_t seed);

inline constexpr int kMostRedraws = 64;

/// A square pinhole picture of about `count` pixels, tile by tile, cut after `count` rays.
std::vector<accel::geometry::Ray> pinhole(const accel::geometry::Vec3d& eye,
                                          const accel::geometry::Vec3d& at, std::size_t count);

}  // namespace sightline::bench
