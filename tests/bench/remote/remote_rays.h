// Rays of a remote measurement: as columns for the wire, and the very same rays in process.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "client/cast_options.h"
#include "client/ray_generator.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

struct RemoteRays {
  /// Rounds to float, so that both sides have the same rays in 24 or 32 bytes on the wire.
  static RemoteRays of(std::span<const accel::geometry::Ray> rays);
  /// About `count` rays of a square picture of the scene, from where overview looks.
  static RemoteRays picture(const SceneSource& scene, std::size_t count);

  client::RayColumns<const float> columns() const;

  std::vector<accel::geometry::Ray> in_process;
  std::vector<float> origins, directions, tmin, tmax;  ///< Empty if the rays are generated.
  client::RayGenerator generator;
  bool generated = false;
};

}  // namespace sightline::bench
