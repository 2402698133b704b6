// Takes the rays of frustums (accel/wide/frustum.h) through a revision of one instance.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "accel/kdtree/epoch.h"
#include "accel/wide/frustum.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/packet.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/query/seen.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

inline constexpr std::size_t kFrustumRays = accel::wide::kFrustumPackets * accel::wide::kLanes;

/// Casts the frustums of one block of rays, on one thread.
class FrustumCaster {
 public:
  /// The columns and the pin must outlive the caster. The pin is renewed for each frustum.
  FrustumCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees,
                const TraceOptions& options, const accel::geometry::RayColumns& rays,
                const accel::geometry::HitColumns& hits);
  FrustumCaster(const FrustumCaster&) = delete;
  FrustumCaster& operator=(const FrustumCaster&) = delete;

  /// Answers `count` rays, at most kFrustumRays, the first one at index `first`, in packets of
  /// wide::kLanes. Returns a bit for each packet that is answered; the others have rays that are
  /// not of the frustum, or a frustum does not suit them.
  std::uint32_t cast(std::size_t first, std::size_t count);
  /// Whether the next packet of a block of rays that ends at `end` is answered: casts the frustum
  /// that begins there.
  bool answers(const RayPacket& packet, std::size_t end);

  /// The stats of all rays answered.
  const TraceStats& stats() const { return stats_; }

 private:
  using Lanes = accel::wide::FrustumLanes;

  /// The rays of a frustum. Its memory is not cleared, and not on the stack, since it is large.
  struct Group {
    Group() {}  // NOLINT(modernize-use-equals-default): that would clear it

    Masks masks;
    std::array<accel::wide::GivenRays, accel::wide::kFrustumPackets> given;
    std::array<accel::wide::BestHits, accel::wide::kFrustumPackets> best;
    std::array<accel::wide::Packet, accel::wide::kFrustumPackets> packets;
  };

  void make_group();
  Lanes read(std::size_t first, std::size_t count);
  std::uint32_t write(std::size_t first, std::size_t count, const Lanes& done);

  accel::kdtree::EpochPin& pin_;
  const instances::OpenTrees trees_;
  const TraceOptions options_;
  const accel::geometry::RayColumns& rays_;
  const accel::geometry::HitColumns& hits_;
  const instances::Instance* const only_;  // null: frustums do not suit the revision
  const bool any_;                         // any hit is asked for
  TraceStats stats_;
  // The next `to_skip_` groups of rays are not tried. Each try sets it to `failed_`, which is then
  // 0 after a success and 2 failed_ + 2 after a failure.
  std::size_t failed_ = 0, to_skip_ = 0;
  std::uint32_t answered_ = 0;    // a bit for each of the next packets
  std::unique_ptr<Group> group_;  // made for the first frustum
};

}  // namespace sightline::scenegraph::query
