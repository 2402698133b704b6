// Where the columns of a cast lie in a segment. Internal to the library.
#pragma once

#include <grpcpp/support/status.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/calls/segment_pool.h"
#include "client/result.h"

namespace sightline::client::calls {

/// A column of a cast, of rays or of answers.
struct ColumnBytes {
  std::byte* data = nullptr;  ///< The caller's; null: it has none, or of another form.
  std::size_t row_bits = 0;   ///< 0: the cast does not have the column.
  bool is_answer = false;

  std::uint64_t bytes(std::uint64_t rows) const { return (rows * row_bits + 7) / 8; }
  bool exists() const { return row_bits > 0; }
};

/// The columns of one cast. Those that lie in the caller's shared memory stay there. The others
/// have regions, in turn: message k has region k modulo their number.
class SegmentColumns {
 public:
  /// How many rows there are, and how many go into a message.
  struct Rows {
    std::uint64_t total = 0;
    std::size_t regions = 1;
    std::uint64_t most = 0;  ///< In a message; a multiple of 8 unless it is the total.
    bool is_one_message = false;
  };

  /// Nothing: there is no segment, or no room.
  static std::optional<SegmentColumns> make(SegmentPool& pool, std::vector<ColumnBytes> columns,
                                            const Rows& rows, const SegmentWait& wait);

  /// Errors: kFailedPrecondition (MEMORY_ABANDONED), the server may still write to a column of
  /// answers.
  static Status check(SegmentPool& pool, std::span<const ColumnBytes> columns);

  const std::string& segment() const { return segment_->name(); }
  std::size_t message_rows() const { return message_rows_; }
  bool exists(std::size_t column) const { return columns_[column].exists(); }

  /// Where, in the segment, a message has its rows, the first of which is row `first` of the cast.
  std::uint64_t offset(std::size_t column, std::uint64_t message, std::uint64_t first) const;
  /// The region of a column; null if it stays where it is.
  std::byte* region(std::size_t column, std::uint64_t message) const;
  /// Copies rows of the columns that are no answers.
  void copy_rows(std::uint64_t message, std::uint64_t first, std::uint64_t count) const;

  /// Call this with the end of each call whose requests name the segment. Returns whether rows
  /// without an answer may be cast again: not where the server might still write to the caller's
  /// memory.
  bool end_call(const grpc::Status& status);

 private:
  SegmentColumns(SegmentPool& pool, std::vector<ColumnBytes> columns);

  bool stay_in(const std::shared_ptr<Segment>& segment, std::uint64_t rows);
  bool overlap(std::uint64_t rows) const;
  bool take_regions(const Rows& rows, const SegmentWait& wait);
  void set_message_rows(const Rows& rows);
  bool answers_stay() const;

  SegmentPool* pool_;
  std::vector<ColumnBytes> columns_;
  std::vector<bool> stays_;                   ///< For each column: it lies in the segment.
  std::vector<std::uint64_t> region_offset_;  ///< For each column, within a region.
  std::shared_ptr<Segment> segment_;
  std::shared_ptr<std::byte> regions_;
  std::size_t region_count_ = 1;
  std::uint64_t region_bytes_ = 0;
  std::size_t message_rows_ = 0;
};

/// Whether the server has the segment of a request that it refused with this error.
bool is_unknown_segment(const Error& error);

}  // namespace sightline::client::calls
