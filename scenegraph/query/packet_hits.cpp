#include "scenegraph/query/packet_hits.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>

#include "accel/wide/surface.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

void write_hits(const PacketHits& packet, std::span<Hit> hits) {
  const accel::wide::BestHits& best = packet.best;
  const std::uint32_t found = best.found & packet.valid, described = packet.any ? 0 : found;
  for (std::uint32_t left = packet.answered; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const bool has_hit = (described >> i & 1) != 0, valid = (packet.valid >> i & 1) != 0;
    Hit& out = hits[i];  // number by number: a copy would wait for what was just stored
    out.t = has_hit ? best.t[i]
            : valid ? accel::geometry::kInfinity
                    : std::numeric_limits<double>::quiet_NaN();
    out.node = has_hit ? best.node[i] : 0;
    out.primitive = has_hit ? best.primitive[i] : 0;
    out.u = out.v = 0;
    out.normal = {};
    const std::uint32_t work = std::min(packet.work[i], accel::geometry::kWorkDeferred - 1);
    const bool deferred = (packet.saw_deferred >> i & 1) != 0;
    out.work = valid ? work | (deferred ? accel::geometry::kWorkDeferred : 0) : 0;
    out.state = (found >> i & 1) != 0 ? HitState::kHit
                : valid               ? HitState::kMiss
                                      : HitState::kInvalid;
  }
}

void write_surfaces(const PacketHits& packet, const instances::OpenTrees& trees, bool trees_kept,
                    std::span<const Ray> rays, std::span<Hit> hits) {
  const accel::wide::BestHits& best = packet.best;
  std::uint32_t left = best.found & packet.answered;
  while (left != 0) {
    const auto first = static_cast<std::size_t>(std::countr_zero(left));
    const instances::Instance& instance = trees[best.instance[first]];
    if (!trees_kept || best.block[first] == nullptr) {
      set_surface(instance, rays[first], hits[first]);
      left &= left - 1;
      continue;
    }
    std::uint32_t same = 0;
    for (std::size_t i = first; i < rays.size(); ++i) {
      const bool here = best.instance[i] == best.instance[first] && best.block[i] != nullptr;
      same |= static_cast<std::uint32_t>(here) << i;
    }
    same &= left;
    left &= ~same;
    accel::wide::Surfaces surfaces;
    accel::wide::find_surfaces(packet.given, best, instance.local_from_world.m, instance.mirrored,
                               same, surfaces);
    for (; same != 0; same &= same - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(same));
      hits[i].u = surfaces.u[i];
      hits[i].v = surfaces.v[i];
      if ((surfaces.no_normal >> i & 1) == 0)
        hits[i].normal = {surfaces.normal[0][i], surfaces.normal[1][i], surfaces.normal[2][i]};
    }
  }
}

}  // namespace sightline::scenegraph::query
