// Writes the columns of an answer to a segment.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "proto/result.h"
#include "server/queries/cast_query.h"
#include "server/queries/segment_range.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::segments {
class Segment;
}  // namespace sightline::server::segments

namespace sightline::server::queries {

/// The rows of each slice are made in columns of the server's own, and then copied: nothing is read
/// back from memory that a client may write. Writes the answer to one batch after the other.
class SegmentAnswer {
 public:
  /// Begins the answer to a batch of `rays`, by the fields of the query. `read`: where its rays are
  /// in the segment, if they are there. Errors: kInvalidArgument: other columns than the fields of
  /// the query (ANSWER_DIFFERS), and as of check_range() and check_disjoint().
  Status begin(const google::protobuf::RepeatedPtrField<v1::SharedColumn>& columns,
               const CastQuery& query, std::size_t rays, std::span<const SegmentRange> read,
               std::uint64_t segment_bytes);

  /// The columns of one slice, whose first ray has row 0.
  v1::CastRaysResponse& slice() { return slice_; }

  /// Copies the rows of the slice of `count` rays that begins with ray `first`, a multiple of
  /// kRaysPerBitsByte. `segment`: of the bytes that begin() was told.
  void write(const segments::Segment& segment, std::size_t first, std::size_t count) const;

 private:
  std::vector<SegmentRange> ranges_;  // of the fields, in their order
  v1::CastRaysResponse slice_;
};

}  // namespace sightline::server::queries
