// The scenes and rays that show whether a method loses hits, and their certain answers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// A closed scene.
struct RobustFamily {
  std::string name;
  SceneSource scene;
  /// True for a sphere around the center of the scene's box: its answers are known. Otherwise the
  /// scene is any mesh inside a closed box.
  bool sphere = false;
  /// The share of the rays that float methods trace: less than 1 if all rays would take hours.
  double share_in_float = 1;
};

/// The spheres icosphere-0, -1e3, -1e5 and -1e7 (moved by this much on every axis), and
/// mesh-in-box.
std::vector<std::string_view> robust_family_names();

/// The families whose name begins with `name`; an empty name: all. `mesh` is the scene in the box,
/// as in --scene; if it is empty, bunny.ply in the folder SIGHTLINE_SCENES; without that folder the
/// box is left out with a message on stderr.
/// Errors: kInvalidArgument: no such family, or the box is requested by name and there is no mesh;
/// those of load_scene.
Result<std::vector<RobustFamily>> make_robust_families(const std::string& name, int level,
                                                       const std::string& mesh);

/// The kinds of rays.
/// vertices: through a vertex, as exactly as doubles allow.
/// edges: through a random point of an edge.
/// random: through a random point of the scene's box.
/// axis: along an axis, every other one through a vertex, so in planes at which trees split.
/// Every other ray of a sphere begins outside, the rest inside; all rays of the box begin inside.
std::vector<std::string_view> robust_ray_kinds();

std::vector<accel::geometry::Ray> make_robust_rays(const RobustFamily& family,
                                                   std::string_view kind, std::size_t count,
                                                   std::uint64_t seed);

/// The number of triangles that a ray may cross.
struct CrossingBounds {
  std::uint32_t least = 0, most = 0;
  bool even = false;  ///< And the number is even.
  /// Only the parity is certain for a ray rounded to float: it may pass the other side of the
  /// silhouette at which it was aimed.
  bool parity_in_float = false;

  bool certain_hit() const { return least > 0; }
};

/// Certain answers for rays and a sphere, from the distances of its faces and vertices from its
/// center: a line through the inside of a closed convex surface crosses it twice, a ray that begins
/// inside crosses it once, and a line that passes outside never crosses it.
class SphereTruth {
 public:
  explicit SphereTruth(const SceneSource& scene);
  CrossingBounds bounds(const accel::geometry::Ray& ray) const;

 private:
  accel::geometry::Vec3d center_;
  double inner_, outer_;  // Radii: the inside contains the inner sphere, and the outer sphere
                          // contains the inside
};

}  // namespace sightline::bench
