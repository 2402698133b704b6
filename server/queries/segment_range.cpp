// Where a column is in a segment.
#include "server/queries/segment_range.h"

#include <fmt/format.h>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {

Result<SegmentRange> check_range(std::string_view name, std::uint64_t begin, std::uint64_t bytes,
                                 std::size_t element, std::uint64_t segment) {
  if (begin % element != 0) {
    return exec::invalid_argument(
        fmt::format("column {} begins at byte {} of the segment, which is no multiple of {}, the "
                    "size of its elements",
                    name, begin, element),
        "COLUMN_ALIGNMENT");
  }
  if (bytes > segment || begin > segment - bytes) {
    return exec::invalid_argument(
        fmt::format("column {} has {} bytes from byte {} on, but the segment has {}", name, bytes,
                    begin, segment),
        "COLUMN_OUTSIDE");
  }
  return SegmentRange{name, begin, bytes};
}

Status check_disjoint(const SegmentRange& range, std::span<const SegmentRange> others) {
  for (const SegmentRange& other : others) {
    if (range.bytes == 0 || other.bytes == 0) continue;
    if (range.begin >= other.end() || other.begin >= range.end()) continue;
    return exec::invalid_argument(
        fmt::format("column {}, bytes {} to {} of the segment, overlaps {}, bytes {} to {}",
                    range.name, range.begin, range.end(), other.name, other.begin, other.end()),
        "COLUMNS_OVERLAP");
  }
  return {};
}

}  // namespace sightline::server::queries
