// The traversal of a bounding volume hierarchy by a ray.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/tree_ray.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/published/bvh/bvh.h"

namespace sightline::accel::published::bvh {

/// Whether and where a ray meets the boxes of a node's two children.
struct BvhMeeting {
  std::array<double, 2> t_in;
  std::array<bool, 2> meets;
};

/// Tests both children. `meets` is never false for a box in which the ray has a hit between its
/// t_in and `limit`: both ends are widened by the ray's slack (see TreeRay).
inline BvhMeeting meet_children(const BvhNode& node, const kdtree::TreeRay& ray, double limit) {
  std::array<double, 2> in{ray.t_in, ray.t_in}, out{limit, limit};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto& nearer = node.bounds[a + 3 * ray.first[a]];
    const auto& farther = node.bounds[a + 3 * (1 - ray.first[a])];
    const double origin = ray.local->origin[a], inverse = ray.inverse[a];
    for (std::size_t side = 0; side < 2; ++side) {
      const double t_near = (static_cast<double>(nearer[side]) - origin) * inverse;
      const double t_far = (static_cast<double>(farther[side]) - origin) * inverse;
      // A ray in the plane of a face has NaN here, which fails both tests.
      in[side] = t_near > in[side] ? t_near : in[side];
      out[side] = t_far < out[side] ? t_far : out[side];
    }
  }
  const double widen = 2 * ray.slack;
  BvhMeeting meeting;
  for (std::size_t side = 0; side < 2; ++side) {
    meeting.t_in[side] = in[side] - widen;
    meeting.meets[side] = meeting.t_in[side] <= out[side];
  }
  return meeting;
}

inline void fetch(const Bvh& bvh, std::uint32_t first, std::uint32_t count) {
  const void* const at = count == BvhNode::kInner
                             ? static_cast<const void*>(bvh.nodes.data() + first)
                             : static_cast<const void*>(bvh.ids.data() + first);
  __builtin_prefetch(at);
}

/// Visits the leaves whose boxes the ray meets, the nearer of two children first.
///
/// `visit` supplies:
///   bool leaf(span<const uint32_t> references)          true: stop the walk
///   double limit()                                      t beyond which nothing matters any more,
///                                                       widened by the slack
template <class Visit>
void walk(const Bvh& bvh, const kdtree::TreeRay& ray, kdtree::WalkCounters& counters,
          Visit& visit) {
  struct Waiting {
    double t_in;
    std::uint32_t first, count;
  };
  std::array<Waiting, kMaxBvhDepth + 2> stack;
  std::size_t waiting = 0;
  std::uint32_t first = bvh.root.first;
  std::uint32_t count = bvh.root.inner ? BvhNode::kInner : bvh.root.count;
  double limit = ray.t_out;
  for (;;) {
    while (count == BvhNode::kInner) {
      ++counters.steps;
      const BvhNode& node = bvh.nodes[first];
      const BvhMeeting meeting = meet_children(node, ray, limit);
      const bool both = meeting.meets[0] && meeting.meets[1];
      if (!both && !meeting.meets[0] && !meeting.meets[1]) {
        count = 0;
        break;
      }
      const std::size_t next =
          both ? (meeting.t_in[1] < meeting.t_in[0] ? 1u : 0u) : (meeting.meets[1] ? 1u : 0u);
      if (both) {
        stack[waiting++] = {meeting.t_in[1 - next], node.first[1 - next], node.count[1 - next]};
        // The other child is prefetched for when the traversal returns to it.
        fetch(bvh, node.first[1 - next], node.count[1 - next]);
      }
      first = node.first[next];
      count = node.count[next];
    }
    if (count > 0) {
      if (visit.leaf(std::span<const std::uint32_t>(bvh.ids.data() + first, count))) return;
      const double now = visit.limit();
      if (now < limit) limit = now;
    }
    do {
      if (waiting == 0) return;
      --waiting;
    } while (stack[waiting].t_in > limit);
    first = stack[waiting].first;
    count = stack[waiting].count;
  }
}

}  // namespace sightline::accel::published::bvh
