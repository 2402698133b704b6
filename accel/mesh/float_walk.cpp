#include "accel/mesh/float_walk.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "accel/wide/float_rays.h"
#include "accel/wide/packet.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::mesh {
namespace {

/// All lanes are the query's ray.
void set_packet(const MeshQuery& query, wide::Packet& packet, wide::BestHits& best) {
  wide::Rays& rays = packet.rays;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rays.origin[axis].fill(query.ray.origin[axis]);
    rays.direction[axis].fill(query.ray.direction[axis]);
  }
  rays.unit.fill(query.ray.unit);
  rays.tmin.fill(query.tmin);
  rays.tmax.fill(query.tmax);
  best.t.fill(query.best_t);
  packet.best = &best;
  packet.culling = query.culling;
  packet.work.fill(0);
}

}  // namespace

FloatWalk::FloatWalk(const PacketWalk& in, wide::Packet& packet, std::size_t lane, MeshQuery& query)
    : in_(in),
      packet_(packet),
      lane_(lane),
      query_(query),
      test_{in.mesh, query, ray_, in.walked} {}

void FloatWalk::walk(wide::Child entry) {
  walk_every(packet_, entry, lane_, *this, *this, totals_);
  in_.walked.steps += totals_.nodes;
  in_.walked.tests += totals_.triangles;
}

bool FloatWalk::visit(kdtree::AtomicSlot& slot, std::uint32_t) {
  const double tmax = std::min(query_.tmax, query_.best_t);
  if (!enter(query_.ray, in_.tree.tree().bounds(), query_.tmin / query_.ray.unit,
             tmax / query_.ray.unit, ray_))
    return false;
  const std::uint64_t before = in_.walked.steps;
  lazy::LazyVisit<FloatWalk> visit{in_.tree, query_, in_.built, *this};
  kdtree::walk(in_.tree.tree(), ray_, slot, in_.walked, visit);
  in_.tree.count_steps(in_.walked.steps - before);
  packet_.stopped = query_.is_done();
  return false;
}

void FloatWalk::visit(const blocks::Block& block, std::uint32_t triangles) {
  // The corners are as the mesh has them: their differences to the center are exact.
  const auto vertex = [&](std::size_t i) { return block.vertex(i) + packet_.center; };
  for (; triangles != 0; triangles &= triangles - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(triangles));
    if (test_.decide(block.id(i), vertex(block.corner(0)[i]), vertex(block.corner(1)[i]),
                     vertex(block.corner(2)[i]))) {
      packet_.stopped = true;
      return;
    }
  }
  tighten();
}

bool FloatWalk::finished(const kdtree::FinishedSubtree& subtree) {
  walk_every(packet_, static_cast<const wide::WideTree&>(subtree).root(), lane_, *this, *this,
             totals_);
  return packet_.stopped;
}

bool FloatWalk::kept(bool stop) {
  tighten();
  return stop;
}

void FloatWalk::tighten() {
  if (!(query_.best_t < packet_.best->t[lane_])) return;
  packet_.best->t[lane_] = query_.best_t;
  wide::tighten(packet_, lane_);
}

bool query_in_floats(const PacketWalk& in, MeshQuery& query) {
  wide::Packet packet;
  wide::BestHits best;
  set_packet(query, packet, best);
  const wide::Prepared prepared = wide::prepare(packet, *in.tree.frame(), 1);
  if (prepared.live == 0) return prepared.slow == 0;
  const wide::Child entry = in.tree.entry();
  // As in query_packet().
  const bool searched_before =
      std::exchange(query.searches_list, query.searches_list || entry.is_node());
  FloatWalk(in, packet, 0, query).walk(entry);
  query.searches_list = searched_before;
  return true;
}

}  // namespace sightline::accel::mesh
