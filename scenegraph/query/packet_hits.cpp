#include "scenegraph/query/packet_hits.h"

#include <bit>
#include <cstdint>

#include "accel/wide/surface.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::Vec3f;
using accel::wide::BestHits;

void write_surface(const Hit& hit, const HitColumns& hits, std::size_t row) {
  if (hits.barycentric.is_asked()) hits.barycentric.set(row, {hit.u, hit.v});
  if (hits.normal.is_asked()) hits.normal.set(row, hit.normal);
}

/// The rays of `lanes` that hit the same instance as `lane`, and whose blocks are known.
std::uint32_t in_one_instance(const BestHits& best, std::uint32_t lanes, std::size_t lane) {
  std::uint32_t same = 0;
  for (std::size_t i = lane; i < accel::wide::kLanes; ++i) {
    const bool here = best.instance[i] == best.instance[lane] && best.block[i] != nullptr;
    same |= static_cast<std::uint32_t>(here) << i;
  }
  return same & lanes;
}

}  // namespace

void write_surfaces(const CastPacket& packet, const instances::OpenTrees& trees,
                    const accel::geometry::RayColumns& rays, const HitColumns& hits) {
  const BestHits& best = packet.outcome.best;
  std::uint32_t left = best.found & packet.outcome.answered;
  while (left != 0) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    if (packet.points || !packet.trees_kept || best.block[lane] == nullptr) {
      const std::size_t row = packet.first + lane;
      Hit hit;
      hit.t = best.t[lane];
      hit.primitive = best.primitive[lane];
      set_surface(trees, best.instance[lane], packet.points, rays[row], hit);
      write_surface(hit, hits, row);
      left &= left - 1;
      continue;
    }
    std::uint32_t same = in_one_instance(best, left, lane);
    left &= ~same;
    accel::wide::Surfaces surfaces;
    accel::wide::find_surfaces(packet.given, best, trees[best.instance[lane]].local_from_world.m,
                               same, surfaces);
    for (; same != 0; same &= same - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(same));
      Hit hit;
      hit.u = surfaces.u[i];
      hit.v = surfaces.v[i];
      if ((surfaces.no_normal >> i & 1) == 0)
        hit.normal = {surfaces.normal[0][i], surfaces.normal[1][i], surfaces.normal[2][i]};
      write_surface(hit, hits, packet.first + i);
    }
  }
}

}  // namespace sightline::scenegraph::query
