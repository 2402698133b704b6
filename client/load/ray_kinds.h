// Rays that are made for a scene: kinds of them, and the part of the scene that they go to.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "client/load/ray_set.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::load {

/// diag is the diagonal of the scene's box.
enum class RayKind : std::uint8_t {
  kOverview,  ///< from a camera that sees the whole scene, as `render` has it
  kCloseup,   ///< from a camera 0.05 diag before a random point of the surface
  kDiffuse,   ///< from what the overview sees, in random directions by the cosine
  kShadow,    ///< from what the overview sees to a light diag above the scene
  kRandom,    ///< from random points of the sphere around the scene
};
extern const std::map<std::string, RayKind> kRayKinds;

/// What a ray hits first. t = +inf: nothing.
struct Found {
  double t = 0;
  std::array<double, 3> normal{};
};
/// One answer per ray, in order.
using Caster = std::function<Result<std::vector<Found>>(std::span<const Ray> rays)>;

/// A point of the surface, where rays of a kind end or begin.
struct Aim {
  std::array<double, 3> point{};
  std::array<double, 3> normal{};  ///< unit, on the side of `eye`
  std::array<double, 3> eye{};     ///< sees the point
};

/// Makes rays of one kind, from points that it finds by casting.
class RayMaker {
 public:
  /// Errors: kFailedPrecondition, the scene is empty, or too few rays hit it; those of the caster.
  static Result<RayMaker> make(RayKind kind, const SceneInfo& scene, const Caster& cast,
                               std::uint64_t seed);
  static constexpr std::size_t kFewestAims = 16;

  /// `count` rays, each other than all before, to or from the part of the points that is `coverage`
  /// (above 0, up to 1) of them.
  RaySet rays(double coverage, std::size_t count) const;

 private:
  RayMaker() = default;

  RayKind kind_ = RayKind::kOverview;
  std::uint64_t seed_ = 0;
  RaySet::Precision precision_ = RaySet::Precision::kFloat;
  double diagonal_ = 0;
  std::array<double, 3> light_{};
  std::vector<Aim> aims_;
};

/// The rays of a file that go to a part of the scene, as for RayMaker::rays(), in order. A ray that
/// hits nothing goes to its point nearest to the middle of the scene. Errors: as RayMaker::make().
Result<RaySet> part_of(const RaySet& rays, double coverage, const SceneInfo& scene,
                       const Caster& cast, std::uint64_t seed);

}  // namespace sightline::client::load
