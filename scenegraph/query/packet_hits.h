// The weights and normals of a packet's hits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray_columns.h"
#include "accel/wide/answers.h"
#include "accel/wide/given_rays.h"
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::query {

/// Neighbouring rays of a batch, at most wide::kLanes of them.
struct RayPacket {
  std::size_t first = 0, count = 0;
  std::uint32_t lanes = first_lanes(count);  ///< The rays that take part.

  static constexpr std::uint32_t first_lanes(std::size_t count) {
    return static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1);
  }
};

/// A packet that has been cast for the closest hits.
struct CastPacket {
  const accel::wide::GivenRays& given;
  const accel::wide::Outcome& outcome;
  std::size_t first = 0;    ///< The packet's first ray.
  bool trees_kept = false;  ///< Whether the blocks that hits lie in still exist.
  bool points = false;      ///< Whether its rays are points.
};

/// Writes weights and normals, as far as they are asked for; together for all hits in one instance.
void write_surfaces(const CastPacket& packet, const instances::OpenTrees& trees,
                    const accel::geometry::RayColumns& rays,
                    const accel::geometry::HitColumns& hits);

}  // namespace sightline::scenegraph::query
