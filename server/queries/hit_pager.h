// The answer to a batch that asks for all hits: made and sent in parts, each of whole rays.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/trace.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// Rays are traced until about so many hits are listed, and on once those are sent.
inline constexpr std::size_t kHitsListed = 65536;

/// Bytes that a batch of so many rays holds at most, whatever it hits: what is listed, before and
/// after it is put in order. `threads` list hits.
std::size_t hit_pager_bytes(std::size_t rays, std::size_t max_hits, int threads);

class HitPager {
 public:
  /// `rays` stay as they are until all parts are made.
  void begin(std::span<const accel::geometry::Ray> rays);

  /// Makes the next part: columns, first_ray and more. Without rays there is one empty part.
  /// Errors: kCancelled.
  Status next(const scenegraph::revision::Snapshot& snapshot,
              const scenegraph::TraceOptions& options, std::span<const v1::HitField> fields,
              v1::CastRaysResponse& reply);

  /// Of the parts so far.
  const scenegraph::TraceStats& stats() const { return stats_; }

 private:
  Status list(const scenegraph::revision::Snapshot& snapshot, scenegraph::TraceOptions options);

  std::span<const accel::geometry::Ray> rays_;
  std::size_t sent_ = 0;    // rays in parts that are made
  std::size_t listed_ = 0;  // rays that are traced
  std::size_t sent_hits_ = 0;
  std::vector<scenegraph::RayTally> tallies_;  // of all rays
  std::vector<accel::geometry::Hit> hits_;     // of the last rays traced
  scenegraph::TraceStats stats_;
};

}  // namespace sightline::server::queries
