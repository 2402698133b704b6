// The choice between hits, for all walks: the limits of a ray, the order of hits and ties, and
// where hits go.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "accel/geometry/facing.h"
#include "accel/geometry/intersect.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// A triangle of the mesh that a packet is in.
struct OfferedTriangle {
  std::uint32_t id = 0;
  const std::uint32_t* block = nullptr;  ///< The block that it lies in; null if not known.
  std::uint32_t index = 0;               ///< Its index in the block.
};

/// Takes a hit of a ray at t, in units of the caller's direction, if it is within the ray's limits.
/// For the nearest or any hit, it replaces the best one if (t, node, id) is less; for every hit, it
/// is added to the sink, once for each cell that it is found in. The caller does the culling.
/// Returns whether farther hits matter less than before: then tighten() the ray.
inline bool offer(Packet& packet, std::size_t lane, double t, const OfferedTriangle& triangle) {
  BestHits& best = *packet.best;
  if (!(t >= packet.rays.tmin[lane] && t <= packet.rays.tmax[lane])) return false;
  if (t > best.t[lane]) return false;
  if (packet.goal == Goal::kEvery) {
    const HitSink& sink = packet.sinks[lane];
    best.found |= 1u << lane;
    if (sink.primitives != nullptr) {
      sink.primitives->add(triangle.id);
      return false;
    }
    if (!sink.list->add({t, packet.node, triangle.id, packet.instance})) return false;
    const ListedHit* last = sink.list->greatest();
    if (last != nullptr) best.t[lane] = last->t;
    return last != nullptr;
  }
  if (t == best.t[lane]) {
    if (packet.node > best.node[lane]) return false;
    if (packet.node == best.node[lane] && triangle.id >= best.primitive[lane]) return false;
  }
  best.t[lane] = t;
  best.node[lane] = packet.node;
  best.primitive[lane] = triangle.id;
  best.instance[lane] = packet.instance;
  best.block[lane] = triangle.block;
  best.triangle[lane] = static_cast<std::uint8_t>(triangle.index);
  best.center[lane] = packet.center;
  best.found |= 1u << lane;
  return true;
}

/// Decides by the hit rule whether a ray of the packet, in its mesh's frame, hits the triangle with
/// these corners; if so, offers the hit and returns what offer() does.
inline bool decide(Packet& packet, std::size_t lane, const geometry::LocalRay& ray,
                   const geometry::Vec3f& a, const geometry::Vec3f& b, const geometry::Vec3f& c,
                   const OfferedTriangle& triangle) {
  const std::optional<double> local = geometry::intersect(ray, a, b, c);
  if (!local || geometry::is_culled(packet.culling, ray, a, b, c)) return false;
  if (packet.from_origin) {
    return geometry::is_ahead(ray, *local, a, b, c) &&
           offer(packet, lane, std::max(*local, 0.0) * ray.unit, triangle);
  }
  return offer(packet, lane, *local * ray.unit, triangle);
}

}  // namespace sightline::accel::wide
