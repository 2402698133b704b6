// Writes the columns of an answer to a segment.
#include "server/queries/segment_answer.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/exec/rpc_status.h"
#include "server/queries/hit_codec.h"
#include "server/segments/segment.h"

namespace sightline::server::queries {

Status SegmentAnswer::begin(const google::protobuf::RepeatedPtrField<v1::SharedColumn>& columns,
                            const CastQuery& query, std::size_t rays,
                            std::span<const SegmentRange> read, std::uint64_t segment_bytes) {
  ranges_.clear();
  const std::size_t asked = query.in_segment ? query.fields.size() : 0;
  const bool agree = asked == static_cast<std::size_t>(columns.size()) &&
                     std::equal(columns.begin(), columns.end(), query.fields.begin(),
                                [](const v1::SharedColumn& column, v1::HitField field) {
                                  return column.field() == field;
                                });
  if (!agree) {
    return exec::invalid_argument(
        fmt::format("`answer` has {} columns, but the stream's first request has {}: all requests "
                    "have the same fields in the same order",
                    columns.size(), asked),
        "ANSWER_DIFFERS");
  }
  for (const v1::SharedColumn& column : columns) {
    auto range = check_range(v1::HitField_Name(column.field()), column.offset(),
                             column_bytes(column.field(), rays, rays),
                             element_bytes(column.field()), segment_bytes);
    if (!range) return range.error();
    if (Status disjoint = check_disjoint(*range, ranges_); !disjoint) return disjoint;
    if (Status disjoint = check_disjoint(*range, read); !disjoint) return disjoint;
    ranges_.push_back(*range);
  }
  return {};
}

void SegmentAnswer::write(const segments::Segment& segment, std::size_t first,
                          std::size_t count) const {
  for (int i = 0; i < slice_.columns_size(); ++i) {
    const v1::HitColumn& column = slice_.columns(i);
    const std::size_t skipped = column_bytes(column.field(), first, first);
    segment.write(ranges_[static_cast<std::size_t>(i)].begin + skipped, column.data().data(),
                  column_bytes(column.field(), count, count));
  }
}

}  // namespace sightline::server::queries
