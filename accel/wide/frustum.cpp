// Looks for a frustum among the rays of some packets, and takes it through the tree.
#include "accel/wide/frustum.h"

#include <bit>
#include <limits>

#include "accel/wide/exact.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/frustum.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/frustum-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// A frustum has at least this number of rays; fewer go on as packets.
constexpr int kLeastFrustum = 8;

int count(const FrustumLanes& lanes) {
  int rays = 0;
  for (const std::uint32_t of_packet : lanes) rays += std::popcount(of_packet);
  return rays;
}

template <bool kAny>
bool walk_as_frustum(std::span<Packet> packets, FrustumRays& rays, bool from_origin,
                     const Frame& frame, Child root, const FrustumLanes& lanes,
                     kdtree::WalkCounters& counters) {
  rays.set_floats(from_origin);
  return Frustum<kAny>(packets, rays, frame, lanes, counters).walk(root);
}

/// Returns the rays that are done.
FrustumLanes find_and_walk(std::span<Packet> packets, const Frame& frame, Child root,
                           const FrustumLanes& lanes, kdtree::WalkCounters& counters) {
  const bool any = packets[0].goal == Goal::kAny;
  FrustumLanes group = lanes;
  FrustumRays rays(packets, frame, group);
  const bool from_origin = rays.from_origin() && count(group) >= kLeastFrustum;
  if (!from_origin) {
    group = lanes;
    if (!any || !rays.toward_end() || count(group) < kLeastFrustum) return {};
  }
  const bool walked =
      any ? walk_as_frustum<true>(packets, rays, from_origin, frame, root, group, counters)
          : walk_as_frustum<false>(packets, rays, from_origin, frame, root, group, counters);
  return walked ? group : FrustumLanes{};
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(find_and_walk);

FrustumLanes walk_frustum(std::span<Packet> packets, const Frame& frame, Child root,
                          const FrustumLanes& lanes, kdtree::WalkCounters& counters) {
  const FrustumLanes done =
      HWY_DYNAMIC_DISPATCH(find_and_walk)(packets, frame, root, lanes, counters);
  if (packets[0].goal == Goal::kNearest) {
    for (std::size_t p = 0; p < packets.size(); ++p) {
      if (done[p] != 0) resolve_from_origin(packets[p], done[p]);
    }
  }
  return done;
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
