// From the best hits of a packet to the answers.
#pragma once

#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "accel/wide/carry.h"
#include "accel/wide/packet.h"
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::query {

/// What is known of a packet's rays when they have been cast.
struct PacketHits {
  const accel::wide::GivenRays& given;
  const accel::wide::BestHits& best;
  const accel::wide::Column<std::uint32_t>& work;
  std::uint32_t answered = 0;      ///< The rays to write.
  std::uint32_t valid = 0;         ///< The rays that are not invalid.
  std::uint32_t saw_deferred = 0;  ///< See Hit::work.
  bool any = false;
};

/// Writes all of the answers but the hits' surfaces.
void write_hits(const PacketHits& packet, std::span<accel::geometry::Hit> hits);

/// Writes weights and normals; together for all hits in one instance. `trees_kept`: blocks that
/// hits lie in are still there.
void write_surfaces(const PacketHits& packet, const instances::OpenTrees& trees, bool trees_kept,
                    std::span<const accel::geometry::Ray> rays,
                    std::span<accel::geometry::Hit> hits);

}  // namespace sightline::scenegraph::query
