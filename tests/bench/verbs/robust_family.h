// The scenes and rays that tell whether a method loses hits, and what is certain of their answers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// A closed scene.
struct RobustFamily {
  std::string name;
  SceneSource scene;
  /// A sphere about the middle of the scene's box: its answers are known. Otherwise anything inside
  /// a closed box.
  bool sphere = false;
  /// The share of the rays that methods in float are asked: less than 1 where they would take
  /// hours.
  double share_in_float = 1;
};

/// The spheres icosphere-0, -1e3, -1e5 and -1e7 (moved so far on every axis), and mesh-in-box.
std::vector<std::string_view> robust_family_names();

/// Those whose name begins with `name`; an empty name: all. `mesh` is what stands in the box, as
/// --scene; if it is empty, bunny.ply in the folder that SIGHTLINE_SCENES names; without that the
/// box is left out with a word on stderr.
/// Errors: kInvalidArgument: no such family, or the box is asked for by name and there is no mesh;
/// those of load_scene.
Result<std::vector<RobustFamily>> make_robust_families(const std::string& name, int level,
                                                       const std::string& mesh);

/// The kinds of rays: vertices, edges, random, axis.
///   vertices  at a vertex, as near as doubles come to it
///   edges     at a random point of an edge
///   random    through a random point of the scene's box
///   axis      along an axis, every other one through a vertex, so in planes that trees split at
/// Every other ray of a sphere begins outside, the rest inside; all rays of the box begin inside.
std::vector<std::string_view> robust_ray_kinds();

std::vector<accel::geometry::Ray> make_robust_rays(const RobustFamily& family,
                                                   std::string_view kind, std::size_t count,
                                                   std::uint64_t seed);

/// How many triangles a ray may cross.
struct CrossingBounds {
  std::uint32_t least = 0, most = 0;
  bool even = false;  ///< And only an even number.
  /// Of a ray rounded to float only the parity is certain: it may pass on the other side of a
  /// silhouette at which it was aimed.
  bool parity_in_float = false;

  bool certain_hit() const { return least > 0; }
};

/// What is certain of rays and a sphere, by the distances of its faces and vertices from its middle
/// alone: a closed convex surface is crossed twice by a line through its inside, once by a ray that
/// begins there, and not at all by a line that passes it.
class SphereTruth {
 public:
  explicit SphereTruth(const SceneSource& scene);
  CrossingBounds bounds(const accel::geometry::Ray& ray) const;

 private:
  accel::geometry::Vec3d center_;
  double inner_, outer_;  // radii: all of the inside holds the inner, the outer holds all of it
};

}  // namespace sightline::bench
