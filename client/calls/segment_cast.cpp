// One message over a stream of its own, or the stream of all casts.
#include "client/calls/segment_cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "client/calls/cast.h"
#include "client/calls/cast_stream.h"
#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/query_calls.h"
#include "client/calls/segment_messages.h"
#include "client/calls/segment_pool.h"

namespace sightline::client::calls {
namespace {

template <class Request>
using StreamOf = grpc::ClientReaderWriter<typename CallsOf<Request>::StreamRequest,
                                          typename CallsOf<Request>::StreamResponse>;

/// Rows beyond which a cast whose names are asked for gets more messages: a reply has names for at
/// most 2 MiB.
template <class Rows>
constexpr std::size_t kNamedRows =
    requires(const Rows& rows) { rows.size(); } ? kRaysPerMessage : kGeneratedRaysPerMessage;

Status check_answers(SegmentPool& pool, const HitColumns& hits) {
  return pool.has_shared() ? SegmentColumns::check(pool, columns_of(hits)) : Status();
}

bool has_answers(const HitColumns& hits) {
  const std::vector<ColumnBytes> columns = columns_of(hits);
  return std::any_of(columns.begin(), columns.end(), [](const auto& c) { return c.exists(); });
}

/// Sends one message, and reads its answer. gRPC repeats CastRays when a connection breaks, and
/// then two calls would write to one region; it does not repeat streams.
template <class Request>
grpc::Status exchange(const Connection& connection,
                      const typename CallsOf<Request>::StreamRequest& message,
                      const std::string& scene, const CastOptions& options,
                      Retries::Deadline deadline,
                      typename CallsOf<Request>::StreamResponse& response) {
  grpc::ClientContext context;
  if (deadline) context.set_deadline(*deadline);
  set_route(context, scene, options.route_key);
  context.set_initial_metadata_corked(true);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  const std::unique_ptr<StreamOf<Request>> stream =
      CallsOf<Request>::open(*connection.queries, context);
  stream->WriteLast(message, grpc::WriteOptions());
  int answers = 0;
  while (stream->Read(&response)) {
    if (++answers > 1) context.TryCancel();
  }
  grpc::Status status = stream->Finish();
  if (status.ok() && answers != 1)
    status = {grpc::INTERNAL, fmt::format("the server gave {} answers to one message", answers)};
  return status;
}

/// `may_be_sent`: after an error, whether messages may answer where the segment did not.
template <class Columns>
Result<CastReport> cast_one(const Connection& connection, const std::string& scene,
                            const HitColumns& hits, const CastOptions& options,
                            Retries::Deadline deadline,
                            SegmentMessages<RequestOf<Columns>>& messages, bool& may_be_sent) {
  using Request = RequestOf<Columns>;
  typename CallsOf<Request>::StreamRequest message;
  Request& request = *message.mutable_request();
  wire::describe(scene, {}, options, request);
  const std::size_t count = messages.set_next(request);
  Retries retries(deadline);
  while (true) {
    typename CallsOf<Request>::StreamResponse response;
    const grpc::Status status =
        exchange<Request>(connection, message, scene, options, deadline, response);
    const bool is_done = messages.end_call(status);
    if (!status.ok()) {
      if (is_done && retries.wait(status, options.stop)) continue;
      may_be_sent = is_done && status.error_code() != grpc::DEADLINE_EXCEEDED &&
                    !retry_delay(status) && !options.stop.stop_requested();
      return rpc_error(status, options.stop);
    }
    const auto answers = messages.view(0, count, response.response());
    if (!answers) return answers.error();
    std::fill(hits.unanswered.begin(), hits.unanswered.end(), std::uint8_t{0});
    copy_hits(*answers, 0, hits);
    CastReport report;
    wire::add_stats(response.response(), report);
    return report;
  }
}

}  // namespace

template <class Columns>
std::optional<Result<CastReport>> cast_in_segment(const Connection& connection,
                                                  const std::string& scene, const Columns& rows,
                                                  const HitColumns& hits,
                                                  const CastOptions& options,
                                                  Retries::Deadline deadline) {
  SegmentPool& pool = *connection.segments;
  if (const Status checked = check_answers(pool, hits); !checked) return checked.error();
  if (rows.size() < kLeastSegmentRows || !has_answers(hits)) return std::nullopt;
  const SegmentWait wait{deadline, options.stop};
  const auto limits = pool.limits(wait);
  if (!limits) return std::nullopt;
  const bool is_large = rows.size() > std::min(limits->rows, limits->rows_of_message) ||
                        (!hits.name.empty() && rows.size() > kNamedRows<Columns>);
  if (is_large) {
    if (auto report = stream_in_segment(connection, scene, rows, hits, options, deadline))
      return report;
    if (rows.size() <= limits->rows_of_message) return std::nullopt;
    return cast_source(connection, scene, source_of(rows), shape_of(rows), fields_of(hits),
                       copy_to(hits), options);
  }
  const auto messages = SegmentMessagesOf<Columns>::make(
      pool, rows, hits, {.total = rows.size(), .most = rows.size(), .is_one_message = true}, wait);
  if (messages == nullptr) return std::nullopt;
  bool may_be_sent = false;
  auto report =
      cast_one<Columns>(connection, scene, hits, options, deadline, *messages, may_be_sent);
  if (may_be_sent) return std::nullopt;
  return report;
}

template <class Rows>
std::optional<Result<CastReport>> stream_in_segment(const Connection& connection,
                                                    const std::string& scene, const Rows& rows,
                                                    const HitColumns& hits,
                                                    const CastOptions& options,
                                                    Retries::Deadline deadline) {
  SegmentPool& pool = *connection.segments;
  if (const Status checked = check_answers(pool, hits); !checked) return checked.error();
  const std::uint64_t total = row_count(rows);
  if (total < kLeastSegmentRows || !has_answers(hits)) return std::nullopt;
  const SegmentWait wait{deadline, options.stop};
  const auto limits = pool.limits(wait);
  if (!limits) return std::nullopt;
  const std::uint64_t most =
      hits.name.empty() ? limits->rows : std::min<std::uint64_t>(limits->rows, kNamedRows<Rows>);
  const auto messages = SegmentMessagesOf<Rows>::make(
      pool, rows, hits, {.total = total, .regions = kMessagesInFlight, .most = most}, wait);
  if (messages == nullptr) return std::nullopt;
  return cast_messages<RequestOf<Rows>>(connection, scene, *messages, fields_of(hits),
                                        copy_to(hits), options, deadline);
}

template std::optional<Result<CastReport>> cast_in_segment(const Connection&, const std::string&,
                                                           const RayColumns<const float>&,
                                                           const HitColumns&, const CastOptions&,
                                                           Retries::Deadline);
template std::optional<Result<CastReport>> cast_in_segment(const Connection&, const std::string&,
                                                           const RayColumns<const double>&,
                                                           const HitColumns&, const CastOptions&,
                                                           Retries::Deadline);
template std::optional<Result<CastReport>> cast_in_segment(const Connection&, const std::string&,
                                                           const PointColumns<const float>&,
                                                           const HitColumns&, const CastOptions&,
                                                           Retries::Deadline);
template std::optional<Result<CastReport>> cast_in_segment(const Connection&, const std::string&,
                                                           const PointColumns<const double>&,
                                                           const HitColumns&, const CastOptions&,
                                                           Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const RayColumns<const float>&,
                                                             const HitColumns&, const CastOptions&,
                                                             Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const RayColumns<const double>&,
                                                             const HitColumns&, const CastOptions&,
                                                             Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const PointColumns<const float>&,
                                                             const HitColumns&, const CastOptions&,
                                                             Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const PointColumns<const double>&,
                                                             const HitColumns&, const CastOptions&,
                                                             Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const RayGenerator&, const HitColumns&,
                                                             const CastOptions&, Retries::Deadline);
template std::optional<Result<CastReport>> stream_in_segment(const Connection&, const std::string&,
                                                             const PointGrid&, const HitColumns&,
                                                             const CastOptions&, Retries::Deadline);

}  // namespace sightline::client::calls
