// The nearest face decides where the nearest point is inside it. Otherwise a second search, at the
// nearest point, lists the faces that meet there, and the sum of their weighted normals decides.
#include "scenegraph/query/normal_sides.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "scenegraph/query/node_faces.h"
#include "scenegraph/query/or_error.h"
#include "scenegraph/query/point_order.h"
#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Part;
using accel::geometry::Ray;
using accel::geometry::RayColumns;
using accel::geometry::Vec3d;

Side side(bool behind) { return behind ? Side::kInside : Side::kOutside; }

/// The sides of a batch of points.
class NormalSides {
 public:
  NormalSides(const revision::Snapshot& snapshot, const RayColumns& points,
              const TraceOptions& options)
      : snapshot_(snapshot), points_(points), options_(options) {
    options_.points = true;
    options_.surface = false;
    options_.kind = QueryKind::kClosest;
    points_.tmax = accel::geometry::for_all(accel::geometry::kInfinity);
    sides_.resize(points.size, Side::kUnanswered);
  }

  Status run() {
    hits_.resize(points_.size);
    const auto traced = trace(snapshot_, points_, columns_of(std::span(hits_)), options_);
    if (Status added = add(traced); !added) return added;
    if (Status done = ask_nearest_faces(); !done) return done;
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < points_.size; ++i) {
      if (radius_[i] > 0) open.push_back(i);
    }
    // Hardly any corner has more faces than the first limit.
    constexpr std::uint64_t kMostHits = std::numeric_limits<std::uint32_t>::max() - 1;
    std::uint64_t limit = 64;
    for (; !open.empty(); limit = std::min(64 * limit, kMostHits)) {
      options_.max_hits = static_cast<std::uint32_t>(limit);
      if (Status done = ask_all(open); !done) return done;
    }
    return {};
  }

  const std::vector<Side>& sides() const { return sides_; }
  const TraceStats& stats() const { return stats_; }

 private:
  Status add(const Result<TraceStats>& traced) {
    if (!traced) return traced.error();
    stats_ += *traced;
    return {};
  }

  /// Decides the points whose nearest point is inside a face, and sets where and how far around to
  /// search for the others.
  Status ask_nearest_faces() {
    around_.resize(points_.size);
    radius_.resize(points_.size);
    const auto answer = [&](const RayBlock& block) {
      NodeFaces faces(snapshot_);
      for (std::size_t i = block.first; i < block.end; ++i) ask_nearest_face(i, faces);
      return TraceStats{};
    };
    return add(run_blocks(points_.size, kRaysPerBlock, options_, answer));
  }

  void ask_nearest_face(std::size_t i, NodeFaces& faces) {
    const Hit& hit = hits_[i];
    if (hit.state == HitState::kUnanswered) return;
    sides_[i] = hit.state == HitState::kInvalid ? Side::kInvalid : Side::kOutside;
    if (hit.state != HitState::kHit || hit.t == 0) return;
    faces.enter(hit.node);
    const Vec3d p = points_[i].origin;
    const accel::geometry::NearestPoint nearest = faces.nearest_point(p, hit);
    if (nearest.feature.part == Part::kInside) {
      sides_[i] = side(faces.is_behind(p, hit, {}));
      return;
    }
    sides_[i] = Side::kUnanswered;
    around_[i] = nearest.position;
    // More than the position is off, and what counts as 0 in a coordinate.
    radius_[i] = 2 * nearest.off + 0x1p-248;
  }

  /// Decides points by all faces around their nearest points. `open` becomes the points around
  /// which there are more than the limit.
  Status ask_all(std::vector<std::uint32_t>& open) {
    const std::vector<std::uint32_t> rest = std::exchange(open, {});
    options_.hits_at_once = std::size_t{1} << 16;
    for (std::span<const std::uint32_t> left = rest; !left.empty();) {
      constexpr std::size_t kMostPoints = 1 << 14;
      const auto some = left.first(std::min(left.size(), kMostPoints));
      std::vector<Ray> rays;
      rays.reserve(some.size());
      for (const std::uint32_t i : some) {
        rays.push_back({.origin = around_[i],
                        .direction = {1, 0, 0},
                        .tmax = radius_[i],
                        .mask = points_.mask[i]});
      }
      std::vector<RayTally> tallies(rays.size());
      std::vector<Hit> listed;
      const auto traced = list_hits(snapshot_, rays, tallies, listed, options_);
      if (Status added = add(traced); !added) return added;
      const bool cancelled = traced->unanswered != 0;
      const auto answered = some.first(cancelled ? some.size() : traced->rays);
      if (Status done = decide(answered, tallies, listed, open); !done) return done;
      if (cancelled) {
        open.clear();
        return {};
      }
      left = left.subspan(answered.size());
    }
    return {};
  }

  /// Decides the points whose faces are listed.
  Status decide(std::span<const std::uint32_t> some, std::span<const RayTally> tallies,
                std::span<const Hit> listed, std::vector<std::uint32_t>& open) {
    struct Listed {
      std::uint32_t point = 0;
      std::span<const Hit> hits;
    };
    std::vector<Listed> points;
    for (std::size_t i = 0, begin = 0; i < some.size(); begin += tallies[i++].count) {
      if (tallies[i].cut_off) {
        open.push_back(some[i]);
      } else if (tallies[i].state != HitState::kUnanswered) {
        points.push_back({some[i], listed.subspan(begin, tallies[i].count)});
      }
    }
    const auto answer = [&](const RayBlock& block) {
      NodeFaces faces(snapshot_);
      for (const Listed& point : std::span(points).subspan(block.first, block.end - block.first)) {
        const std::uint32_t i = point.point;
        faces.enter(hits_[i].node);
        sides_[i] = side(faces.is_behind(points_[i].origin, hits_[i], point.hits));
      }
      return TraceStats{};
    };
    return add(run_blocks(points.size(), kRaysPerListBlock, options_, answer));
  }

  const revision::Snapshot& snapshot_;
  RayColumns points_;
  TraceOptions options_;
  TraceStats stats_;
  std::vector<Hit> hits_;
  std::vector<Side> sides_;
  std::vector<Vec3d> around_;   // where to search again
  std::vector<double> radius_;  // and how far; 0: not at all
};

}  // namespace

Result<TraceStats> sides_by_normal(const revision::Snapshot& snapshot, const RayColumns& points,
                                   std::span<Side> sides, const TraceOptions& options) {
  return or_error([&]() -> Result<TraceStats> {
    const OrderedPoints ordered(points);
    NormalSides found(snapshot, ordered.columns, options);
    if (const Status done = found.run(); !done) return done.error();
    for (std::size_t i = 0; i < points.size; ++i) {
      const std::size_t at = ordered.order[i];
      sides[at] = std::isnan(points.tmax[at]) ? Side::kInvalid : found.sides()[i];
    }
    return found.stats();
  });
}

}  // namespace sightline::scenegraph::query
