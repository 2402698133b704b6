// A question by one ray to the tree of a mesh, as a packet of one ray.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "accel/geometry/ray.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/packet.h"

namespace sightline::tests {

/// All rays of a packet are this one.
inline void set_ray(const accel::geometry::LocalRay& ray, double tmin, double tmax,
                    accel::wide::Rays& out) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.origin[axis].fill(ray.origin[axis]);
    out.direction[axis].fill(ray.direction[axis]);
  }
  out.unit.fill(ray.unit);
  out.tmin.fill(tmin);
  out.tmax.fill(tmax);
}

/// The question, and, once asked, the answer. t is in units of the caller's direction.
struct MeshQuery {
  accel::geometry::LocalRay ray;
  double tmin = 0, tmax = accel::geometry::kInfinity;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  accel::wide::Goal goal = accel::wide::Goal::kNearest;
  accel::wide::HitSink sink;  ///< For Goal::kEvery.
  std::uint64_t node = 1;
  accel::lazy::CellQuery cells;
  bool found = false;
  double best_t = std::numeric_limits<double>::max();
  std::uint32_t best_primitive = 0;
  bool saw_deferred = false;
  bool stopped = false;
};

inline MeshQuery query_of(const accel::geometry::Ray& ray) {
  MeshQuery query;
  query.ray = *make_local_ray(ray.origin, ray.direction);
  query.tmin = ray.tmin;
  query.tmax = ray.tmax;
  return query;
}

/// Asks once. The caller is pinned.
inline void ask(accel::mesh::MeshTree& tree, MeshQuery& query, accel::kdtree::WalkCounters& walked,
                accel::kdtree::BuildCounters& built) {
  const auto packet = std::make_unique<accel::wide::Packet>();
  accel::wide::BestHits best;
  best.clear();
  set_ray(query.ray, query.tmin, query.tmax, packet->rays);
  packet->best = &best;
  packet->goal = query.goal;
  packet->culling = query.culling;
  packet->node = query.node;
  packet->sinks = std::span(&query.sink, 1);
  packet->work.fill(0);
  tree.query(*packet, 1, query.cells, walked, built);
  query.found = (best.found & 1) != 0;
  query.best_t = best.t[0];
  query.best_primitive = best.primitive[0];
  query.saw_deferred = packet->saw_deferred != 0;
  query.stopped = packet->stopped;
}

}  // namespace sightline::tests
