// A ray of a packet in doubles, prepared for one tree, for what is not walked in floats.
#pragma once

#include <algorithm>
#include <cstddef>

#include "accel/kdtree/tree_ray.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// A ray that refers to its packet, whose best hits shorten the ray.
class LaneRay {
 public:
  LaneRay(const Packet& packet, std::size_t lane, const geometry::Aabb& bounds)
      : packet_(packet), lane_(lane), local_(ray_of(packet.rays, lane)) {
    const double tmax = std::min(packet.rays.tmax[lane], packet.best->t[lane]);
    meets_ =
        enter(local_, bounds, packet.rays.tmin[lane] / local_.unit, tmax / local_.unit, in_tree_);
  }
  LaneRay(const LaneRay&) = delete;
  LaneRay& operator=(const LaneRay&) = delete;

  std::size_t lane() const { return lane_; }
  const geometry::LocalRay& local() const { return local_; }
  /// Whether the ray may meet the bounds within its limits; if not, in_tree() is not set.
  bool meets() const { return meets_; }
  const kdtree::TreeRay& in_tree() const { return in_tree_; }
  /// The t beyond which nothing matters any more, widened by the slack.
  double limit() const {
    if ((packet_.live >> lane_ & 1) != 0) {
      const double t_out = static_cast<double>(packet_.floats.t_out[lane_]);
      return (t_out + packet_.floats.shift[lane_]) / packet_.scale;
    }
    return packet_.best->t[lane_] / local_.unit + in_tree_.slack;
  }

 private:
  const Packet& packet_;
  const std::size_t lane_;
  const geometry::LocalRay local_;
  kdtree::TreeRay in_tree_;
  bool meets_ = false;
};

}  // namespace sightline::accel::wide
