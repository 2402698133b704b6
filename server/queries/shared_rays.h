// The rays or points of a request that are in a segment.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "server/queries/segment_range.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::segments {
class Segment;
}  // namespace sightline::server::segments

namespace sightline::server::queries {

/// Checked columns of a segment. Their client may write them at any time, so rays are copied before
/// anything is done with them, each value once.
class SharedRays {
 public:
  /// Errors: kResourceExhausted over `most` rays, else kInvalidArgument as of check_range().
  static Result<SharedRays> decode(const v1::SharedRays& message, std::uint64_t segment_bytes,
                                   std::size_t most);
  static Result<SharedRays> decode(const v1::SharedPoints& message, std::uint64_t segment_bytes,
                                   std::size_t most);

  std::size_t size() const { return size_; }
  /// Where the columns are.
  std::span<const SegmentRange> ranges() const { return {ranges_.data(), range_count_}; }

  /// Copies `count` rays from `first` on, which the columns have, to `copy`, and returns a view of
  /// them there. `segment`: of the bytes that decode() was told.
  accel::geometry::RayColumns copy(const segments::Segment& segment, std::size_t first,
                                   std::size_t count, std::vector<double>& copy) const;

 private:
  /// What a column is of a ray.
  enum class Part : std::uint8_t { kOrigin, kDirection, kTmin, kTmax, kMask };
  struct Column {
    Part part;
    std::size_t row_bytes;
  };
  static constexpr std::size_t kMostColumns = 5;

  Status add(Part part, const char* name, std::uint64_t begin, std::uint64_t segment_bytes);

  bool points_ = false, float64_ = false;
  std::size_t size_ = 0;
  std::size_t range_count_ = 0;
  std::array<SegmentRange, kMostColumns> ranges_{};
  std::array<Column, kMostColumns> columns_{};  // those of ranges_
};

}  // namespace sightline::server::queries
