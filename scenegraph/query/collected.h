// The hits of one ray that asks for more than one: their number, or a list of the nearest.
#pragma once

#include <cstdint>
#include <span>

#include "accel/wide/packet.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// The hits of one ray. It keeps its memory for the next ray.
class Collected {
 public:
  /// Lists search for one hit more than is kept: whether hits are cut off is then exact, and does
  /// not depend on where the walk stops.
  explicit Collected(std::uint32_t max_hits)
      : max_hits_(max_hits), list_(std::size_t{max_hits} + 1) {}

  /// Begins a ray, and returns where its hits go: for kAll a list for all meshes, for kCount the
  /// primitives of one instance. Both are null for other kinds.
  accel::wide::HitSink begin(QueryKind kind);
  /// Returns where hits in a flat tree go, after begin(): for kCount the primitives of all its
  /// meshes, in their common numbering.
  accel::wide::HitSink sink_of_flat(QueryKind kind) {
    return {.list = kind == QueryKind::kAll ? &list_ : nullptr,
            .primitives = kind == QueryKind::kCount ? &flat_primitives_ : nullptr};
  }
  /// Whether the ray has not entered the instance before.
  bool enter(std::uint32_t instance) { return entered_.add(instance); }
  /// kCount: counts the primitives that were hit in an instance. To be called after its mesh was
  /// queried, if the ray has hit anything so far.
  void end_mesh() {
    counted_ += primitives_.sorted().size();
    primitives_.clear();
  }

  /// kCount: the number of hits, at most kMaxCount. Adds to the statistics.
  std::uint32_t count(TraceStats& stats);
  /// kAll: the hits that are kept, ascending, and whether others are cut off. Adds to the
  /// statistics.
  std::span<const accel::wide::ListedHit> list(TraceStats& stats, bool& cut_off);

 private:
  const std::uint32_t max_hits_;
  accel::wide::UniqueHits<accel::wide::ListedHit> list_;
  accel::wide::UniqueHits<std::uint32_t> primitives_;  // hit in the instance that the ray is in
  accel::wide::UniqueHits<std::uint32_t> flat_primitives_;
  EnteredOnce entered_;
  std::uint64_t counted_ = 0;  // hits in the instances so far
};

}  // namespace sightline::scenegraph::query
