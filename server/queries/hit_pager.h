// Lists the hits of a batch in parts that fit a reply.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace.h"
#include "server/queries/derived_columns.h"
#include "server/queries/hit_codec.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// Tracing pauses after about `hits` hits, and continues when their parts are made. A block of
/// rays, which one thread lists, has at most `of_block`, unless a single ray has more.
struct ListSize {
  std::size_t hits = 0;
  std::size_t of_block = 0;
};
inline constexpr ListSize kFullList{65536, 16384};
/// The size of lists while it is not known whether a batch has many hits.
inline constexpr ListSize kFirstList{4096, 1024};

/// Most hits of one part of several, unless a single ray has more.
inline constexpr std::size_t kHitsPerPart = 4096;

/// Most bytes that a batch of `rays` rays holds, with `threads` threads listing hits: the hits
/// before and after they are sorted by ray, and those that wait for the rest of their part.
std::size_t hit_pager_bytes(std::size_t rays, std::size_t max_hits, int threads,
                            const ListSize& size);

/// Answers a batch that asks for all hits in parts, each of whole rays. Where parts end depends on
/// the hits alone, not on the sizes of lists and threads, so that a batch that is asked again has
/// the same parts.
class HitPager {
 public:
  /// Starts a batch with lists of this size, and parts of `part_hits` hits, unless a single ray has
  /// more. `rays` must not change until all parts are made.
  void begin(std::span<const accel::geometry::Ray> rays, const ListSize& size,
             std::size_t part_hits);
  /// Whether a part was made and is not the last one: the batch has many hits.
  bool goes_on() const { return sent_ > 0; }
  /// Sets the size of lists from the next one on.
  void set_list_size(const ListSize& size) { size_ = size; }

  /// Makes the next part: columns, first_ray and more. A batch without rays has one empty part.
  /// Errors: kCancelled, and as of DerivedColumns::write_lists().
  Status next(const scenegraph::revision::Snapshot& snapshot,
              const scenegraph::TraceOptions& options, std::span<const v1::HitField> fields,
              v1::CastRaysResponse& reply);

  /// Totals of the parts made so far.
  const scenegraph::TraceStats& stats() const { return stats_; }

 private:
  Status list(const scenegraph::revision::Snapshot& snapshot, scenegraph::TraceOptions options);

  std::span<const accel::geometry::Ray> rays_;
  std::size_t sent_ = 0;       // rays in parts that are made
  std::size_t listed_ = 0;     // rays that are traced
  std::size_t sent_hits_ = 0;  // hits of hits_ in those parts
  std::size_t part_hits_ = kHitsPerPart;
  ListSize size_ = kFirstList;
  std::vector<scenegraph::RayTally> tallies_;  // all rays
  std::vector<accel::geometry::Hit> hits_;     // from the last part made on, and some before
  DerivedColumns derived_;
  scenegraph::TraceStats stats_;
};

}  // namespace sightline::server::queries
