// Rays of a pencil (accel/wide/pencil.h) on their way through a revision of one instance.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "accel/kdtree/epoch.h"
#include "accel/wide/carry.h"
#include "accel/wide/packet.h"
#include "accel/wide/pencil.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

inline constexpr std::size_t kPencilRays = accel::wide::kPencilPackets * accel::wide::kLanes;

/// For one block of rays, on one thread, which it pins to an epoch.
class PencilCaster {
 public:
  PencilCaster(const instances::OpenTrees& trees, const TraceOptions& options);
  PencilCaster(const PencilCaster&) = delete;
  PencilCaster& operator=(const PencilCaster&) = delete;

  /// Answers rays, at most kPencilRays of them, in packets of wide::kLanes. Returns a bit for each
  /// packet that is answered; the others have rays that are not of the pencil, or a pencil does not
  /// suit them.
  std::uint32_t cast(std::span<const accel::geometry::Ray> rays,
                     std::span<accel::geometry::Hit> hits);

  /// Of all rays answered.
  const TraceStats& stats() const { return stats_; }

 private:
  using Lanes = accel::wide::PencilLanes;

  Lanes read(std::span<const accel::geometry::Ray> rays);
  std::uint32_t write(std::span<const accel::geometry::Ray> rays,
                      std::span<accel::geometry::Hit> hits, const Lanes& done);

  accel::kdtree::EpochPin pin_;  // renewed for each pencil
  const instances::OpenTrees trees_;
  const TraceOptions options_;
  const instances::Instance* only_ = nullptr;  // null: pencils do not suit the revision
  TraceStats stats_;
  // After a failure, as many groups of rays are not tried; twice as many and one after the next.
  std::size_t failed_ = 0, to_skip_ = 0;
  std::array<accel::wide::GivenRays, accel::wide::kPencilPackets> given_;
  std::array<accel::wide::BestHits, accel::wide::kPencilPackets> best_;
  std::array<accel::wide::Packet, accel::wide::kPencilPackets> packets_;
};

}  // namespace sightline::scenegraph::query
