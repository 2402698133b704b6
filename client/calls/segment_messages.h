// The messages of a cast whose rows or answers are in a segment. Internal to the library.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "client/calls/columns.h"
#include "client/calls/message_source.h"
#include "client/calls/query_calls.h"
#include "client/calls/segment_columns.h"
#include "client/calls/segment_rows.h"
#include "client/wire/cast_codec.h"

namespace sightline::client::calls {

/// Messages for a call of one or many. Request is v1::CastRaysRequest or v1::QueryPointsRequest.
/// Threads: set_next() one, the others another.
template <class Request>
class SegmentMessages {
 public:
  using Response = typename CallsOf<Request>::Response;

  virtual ~SegmentMessages() = default;

  /// Sets the rows of the next message and where their answers go. Returns their number; 0: there
  /// are no more.
  virtual std::size_t set_next(Request& request) = 0;
  /// The answers to `count` rays of a message, other than those that are already where the caller
  /// wants them. They are valid until the next view. Errors: as wire::view_hits().
  virtual Result<HitView> view(std::uint64_t message, std::size_t count,
                               const Response& response) = 0;
  /// As SegmentColumns::end_call().
  virtual bool end_call(const grpc::Status& status) = 0;
  virtual std::uint64_t rows() const = 0;
  /// Messages without a segment, for the rows from `first` on.
  virtual MessageSource<Request> rest(std::uint64_t first) = 0;
};

/// Rows are RayColumns, PointColumns, RayGenerator or PointGrid.
template <class Rows>
class SegmentMessagesOf final : public SegmentMessages<RequestOf<Rows>> {
 public:
  using Request = RequestOf<Rows>;
  using typename SegmentMessages<Request>::Response;

  /// The arrays that `rows` and `hits` name outlive this. Null: there is no segment, or no room.
  static std::unique_ptr<SegmentMessagesOf> make(SegmentPool& pool, const Rows& rows,
                                                 const HitColumns& hits,
                                                 const SegmentColumns::Rows& how,
                                                 const SegmentWait& wait) {
    std::vector<ColumnBytes> columns = columns_of(rows);
    const std::size_t answers = columns.size();
    for (const ColumnBytes& column : columns_of(hits)) columns.push_back(column);
    auto made = SegmentColumns::make(pool, std::move(columns), how, wait);
    if (!made) return nullptr;
    return std::unique_ptr<SegmentMessagesOf>(
        new SegmentMessagesOf(rows, how.total, *std::move(made), answers));
  }

  std::size_t set_next(Request& request) override {
    const std::uint64_t count = std::min<std::uint64_t>(columns_.message_rows(), total_ - next_);
    if (count == 0) return 0;
    request.set_segment(columns_.segment());
    set_rows(rows_, columns_, message_, next_, count, request);
    request.clear_answer();
    std::size_t column = first_answer_;
    HitView every;
    for_each_column(every, [&](auto&, v1::HitField field, std::size_t) {
      add_answer(column++, field, request);
    });
    add_answer(column, v1::HIT_FIELD_NAME, request);
    next_ += count;
    ++message_;
    return count;
  }

  Result<HitView> view(std::uint64_t message, std::size_t count,
                       const Response& response) override {
    HitView hits;
    std::size_t column = first_answer_;
    for_each_column(hits, [&](auto& values, v1::HitField, std::size_t width) {
      set_view(column++, message, width == 0 ? bits_bytes(count) : width * count, values);
    });
    // Names are found by these rows: another process cannot change a copy after it is checked.
    std::span<const std::uint32_t> names;
    set_view(column, message, count, names);
    name_rows_.assign(names.begin(), names.end());
    hits.name = name_rows_;
    if (const Status checked = wire::complete_view(response, columns_.exists(column), count, hits);
        !checked)
      return checked.error();
    return hits;
  }

  bool end_call(const grpc::Status& status) override { return columns_.end_call(status); }

  std::uint64_t rows() const override { return total_; }

  MessageSource<Request> rest(std::uint64_t first) override {
    rest_.emplace(rest_of(rows_, first));
    if constexpr (requires { rest_->first; }) {
      return *messages_of<Request>(*rest_);
    } else {
      rest_source_ = source_of(*rest_);
      return messages_of<Request>(rest_source_, shape_of(*rest_));
    }
  }

 private:
  struct None {};
  /// What copies the rest of columns.
  template <class Any>
  struct SourceOf {
    using Type = None;
  };
  template <class Any>
    requires requires(const Any& rows) { source_of(rows); }
  struct SourceOf<Any> {
    using Type = decltype(source_of(std::declval<const Any&>()));
  };

  SegmentMessagesOf(const Rows& rows, std::uint64_t total, SegmentColumns columns,
                    std::size_t first_answer)
      : rows_(rows), total_(total), columns_(std::move(columns)), first_answer_(first_answer) {}

  void add_answer(std::size_t column, v1::HitField field, Request& request) const {
    if (!columns_.exists(column)) return;
    v1::SharedColumn& answer = *request.add_answer();
    answer.set_field(field);
    answer.set_offset(columns_.offset(column, message_, next_));
  }

  template <class T>
  void set_view(std::size_t column, std::uint64_t message, std::size_t values,
                std::span<const T>& out) const {
    if (!columns_.exists(column)) return;
    if (const std::byte* region = columns_.region(column, message))
      out = {reinterpret_cast<const T*>(region), values};
  }

  const Rows rows_;
  const std::uint64_t total_;
  SegmentColumns columns_;
  const std::size_t first_answer_;  ///< Among the columns.
  std::uint64_t message_ = 0;
  std::uint64_t next_ = 0;
  std::vector<std::uint32_t> name_rows_;
  std::optional<Rows> rest_;
  typename SourceOf<Rows>::Type rest_source_;
};

}  // namespace sightline::client::calls
