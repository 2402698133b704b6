// Columns in place, and regions for the others.
#include "client/calls/segment_columns.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <utility>

#include "client/calls/connection.h"

namespace sightline::client::calls {
namespace {

// Rows of a message whose columns are copied: few enough to stay in the caches, and enough that a
// message costs little a ray.
constexpr std::uint64_t kRegionBytes = std::uint64_t{2} << 20;
constexpr std::uint64_t kLeastRows = 16384;
constexpr std::uint64_t kMostRows = 65536;
// A cast has at least this number of messages, if they have kLeastRows: copying and tracing
// overlap.
constexpr std::uint64_t kMessages = 8;
constexpr std::uint64_t kRowsAtOnce = 4096;  // what the server traces at a time

std::uint64_t aligned(std::uint64_t bytes) {
  constexpr std::uint64_t kMask = BlockList::kAlignment - 1;
  return (bytes + kMask) & ~kMask;
}

// How long the end of a process may come after that of its connections.
constexpr std::chrono::milliseconds kProcessEnd{500};

/// Whether the server itself has ended a call with this status, after all of its work: its errors
/// have reasons. Others come from this side, or from between.
bool is_of_server(const grpc::Status& status) {
  return status.ok() || !rpc_error(status).reason.empty();
}

}  // namespace

bool is_unknown_segment(const Error& error) { return error.reason == "SEGMENT_NOT_FOUND"; }

SegmentColumns::SegmentColumns(SegmentPool& pool, std::vector<ColumnBytes> columns)
    : pool_(&pool),
      columns_(std::move(columns)),
      stays_(columns_.size()),
      region_offset_(columns_.size()) {}

Status SegmentColumns::check(SegmentPool& pool, std::span<const ColumnBytes> columns) {
  for (const ColumnBytes& column : columns) {
    if (!column.is_answer || column.data == nullptr) continue;
    const auto segment = pool.find(column.data);
    if (segment != nullptr && segment->is_abandoned())
      return Error{Code::kFailedPrecondition,
                   "columns of answers lie in shared memory that is not: " +
                       segment->why_not_shared() + ". Share new memory",
                   "MEMORY_ABANDONED"};
  }
  return {};
}

std::optional<SegmentColumns> SegmentColumns::make(SegmentPool& pool,
                                                   std::vector<ColumnBytes> columns,
                                                   const Rows& rows, const SegmentWait& wait) {
  SegmentColumns made(pool, std::move(columns));
  std::shared_ptr<Segment> user;
  for (const ColumnBytes& column : made.columns_) {
    if (column.data != nullptr) user = pool.find(column.data);
    if (user != nullptr) break;
  }
  if (user != nullptr && made.stay_in(user, rows.total) && made.take_regions(rows, wait))
    return made;
  std::fill(made.stays_.begin(), made.stays_.end(), false);
  made.segment_.reset();
  if (!made.take_regions(rows, wait)) return std::nullopt;
  return made;
}

bool SegmentColumns::stay_in(const std::shared_ptr<Segment>& segment, std::uint64_t rows) {
  if (!segment->is_shared()) return false;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ColumnBytes& column = columns_[i];
    stays_[i] = column.data != nullptr && segment->contains(column.data, column.bytes(rows));
  }
  segment_ = segment;
  return !overlap(rows);
}

/// Whether answers in place would be written over rows, or over other answers.
bool SegmentColumns::overlap(std::uint64_t rows) const {
  constexpr std::less<const std::byte*> kBefore;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const ColumnBytes &one = columns_[i], &other = columns_[k];
      if (i == k || !stays_[i] || !stays_[k] || !one.is_answer) continue;
      if (kBefore(one.data, other.data + other.bytes(rows)) &&
          kBefore(other.data, one.data + one.bytes(rows)))
        return true;
    }
  }
  return false;
}

void SegmentColumns::set_message_rows(const Rows& rows) {
  std::uint64_t copied_bits = 0;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (!stays_[i]) copied_bits += columns_[i].row_bits;
  std::uint64_t most = rows.most;
  if (rows.is_one_message) {
    most = rows.total;
  } else if (copied_bits > 0) {
    const std::uint64_t part = std::clamp(rows.total / kMessages, kLeastRows, kMostRows);
    most = std::min({most, part, 8 * kRegionBytes / copied_bits});
  }
  // Bits of answers begin at whole bytes.
  const std::uint64_t step = most < kRowsAtOnce ? 8 : kRowsAtOnce;
  message_rows_ = most < rows.total ? most / step * step : rows.total;
}

bool SegmentColumns::take_regions(const Rows& rows, const SegmentWait& wait) {
  set_message_rows(rows);
  if (message_rows_ == 0) return false;
  region_count_ = rows.regions;
  region_bytes_ = 0;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    region_offset_[i] = region_bytes_;
    if (!stays_[i]) region_bytes_ += aligned(columns_[i].bytes(message_rows_));
  }
  if (segment_ != nullptr && region_bytes_ == 0) return true;
  const std::uint64_t bytes = region_count_ * region_bytes_;
  if (segment_ != nullptr) {
    regions_ = segment_->take(bytes);
    return regions_ != nullptr;
  }
  auto block = pool_->take(bytes, wait);
  if (!block) return false;
  segment_ = std::move(block->segment);
  regions_ = std::move(block->data);
  return true;
}

std::byte* SegmentColumns::region(std::size_t column, std::uint64_t message) const {
  if (stays_[column]) return nullptr;
  return regions_.get() + message % region_count_ * region_bytes_ + region_offset_[column];
}

std::uint64_t SegmentColumns::offset(std::size_t column, std::uint64_t message,
                                     std::uint64_t first) const {
  if (const std::byte* copy = region(column, message)) return segment_->offset_of(copy);
  return segment_->offset_of(columns_[column].data) + columns_[column].bytes(first);
}

void SegmentColumns::copy_rows(std::uint64_t message, std::uint64_t first,
                               std::uint64_t count) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ColumnBytes& column = columns_[i];
    if (stays_[i] || column.is_answer || !column.exists()) continue;
    std::memcpy(region(i, message), column.data + column.bytes(first), column.bytes(count));
  }
}

bool SegmentColumns::answers_stay() const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (stays_[i] && columns_[i].is_answer) return true;
  return false;
}

bool SegmentColumns::end_call(const grpc::Status& status) {
  if (is_of_server(status)) {
    if (!status.ok() && is_unknown_segment(rpc_error(status))) pool_->lose(*segment_);
    return true;
  }
  const bool is_broken = is_broken_connection(rpc_error(status).code);
  if (segment_->has_server_ended(is_broken ? kProcessEnd : std::chrono::milliseconds(0))) {
    pool_->lose(*segment_);
    return true;
  }
  // Late answers must not reach the rows of another cast.
  segment_->abandon();
  return !answers_stay();
}

}  // namespace sightline::client::calls
