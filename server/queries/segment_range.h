// Where a column is in a segment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "proto/result.h"

namespace sightline::server::queries {

/// The bytes of a column in a segment.
struct SegmentRange {
  std::string_view name;  ///< The column's, for messages.
  std::uint64_t begin = 0, bytes = 0;

  std::uint64_t end() const { return begin + bytes; }
};

/// A column of `bytes` at `begin`, of elements of `element` bytes, in a segment of `segment` bytes.
/// Errors: kInvalidArgument, naming the column, its place and the limit: COLUMN_ALIGNMENT, where it
/// does not begin at a multiple of its element's size; COLUMN_OUTSIDE, where it is not within the
/// segment.
Result<SegmentRange> check_range(std::string_view name, std::uint64_t begin, std::uint64_t bytes,
                                 std::size_t element, std::uint64_t segment);

/// Errors: kInvalidArgument (COLUMNS_OVERLAP), naming both columns, if the range has a byte of one
/// of the others.
Status check_disjoint(const SegmentRange& range, std::span<const SegmentRange> others);

}  // namespace sightline::server::queries
