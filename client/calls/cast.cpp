// Casts rays in one message, or in those of a stream; points alike.
#include "client/calls/cast.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "client/calls/apply.h"
#include "client/calls/attempts.h"
#include "client/calls/cast_stream.h"
#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/message_source.h"
#include "client/calls/query_calls.h"
#include "client/calls/segment_cast.h"
#include "client/calls/side_check.h"
#include "client/wire/cast_codec.h"

namespace sightline::client::calls {
namespace {

template <class Scalar>
void set_rows(const RayColumns<const Scalar>& rays, v1::CastRaysRequest& request) {
  v1::Rays& out = *request.mutable_rays();
  copy_part(rays, 0, wire::resize_columns<Scalar>(rays.size(), shape_of(rays), out));
}

template <class Scalar>
void set_rows(const PointColumns<const Scalar>& points, v1::QueryPointsRequest& request) {
  v1::Points& out = *request.mutable_points();
  copy_part(points, 0, wire::resize_columns<Scalar>(points.size(), shape_of(points), out));
}

template <class Columns>
Status check(const Columns& rows, const HitColumns& hits, const CastOptions& options) {
  if (Status checked = check_kind(options.kind); !checked) return checked;
  if (Status checked = check_rows(rows, hits); !checked) return checked;
  if (rows.size() == 0 && has_sides(options)) return check(rows, hits, without_sides(options));
  return CallsOf<RequestOf<Columns>>::check(options, fields_of(hits));
}

/// The request of a batch that was checked.
template <class Columns>
RequestOf<Columns> make_request(const std::string& scene, const Columns& rows,
                                const HitColumns& hits, const CastOptions& options) {
  RequestOf<Columns> request;
  wire::describe(scene, fields_of(hits), rows.size() == 0 ? without_sides(options) : options,
                 request);
  set_rows(rows, request);
  return request;
}

/// Makes the call, and repeats it.
template <class Request>
Result<typename CallsOf<Request>::Response> send(const Connection& connection,
                                                 const Request& request, const CastOptions& options,
                                                 Repeat repeat) {
  Attempts attempts(connection.timeout, repeat);
  typename CallsOf<Request>::Response response;
  while (true) {
    grpc::ClientContext context;
    if (attempts.deadline()) context.set_deadline(*attempts.deadline());
    set_route(context, request.scene(), options.route_key);
    const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
    const grpc::Status status =
        CallsOf<Request>::call(*connection.queries, context, request, response);
    if (status.ok()) return response;
    const auto pause = attempts.pause(status);
    if (!pause) return rpc_error(status, options.stop);
    if (!sleep_unless_stopped(*pause, options.stop))
      return Error{Code::kCancelled, "cancelled", {}};
  }
}

/// Copies the answers to n rays or points into `hits`.
template <class Response>
Result<CastReport> read_response(const Response& response, std::size_t n, const HitColumns& hits) {
  const auto answers = wire::view_hits(response, fields_of(hits), n);
  if (!answers) return answers.error();
  std::fill(hits.unanswered.begin(), hits.unanswered.end(), std::uint8_t{0});
  copy_hits(*answers, 0, hits);
  CastReport report;
  wire::add_stats(response, report);
  return report;
}

}  // namespace

template <class Columns>
Result<CastReport> cast(const Connection& connection, const std::string& scene, const Columns& rows,
                        const HitColumns& hits, const CastOptions& options) {
  if (const Status checked = check(rows, hits, options); !checked) return checked.error();
  if (auto report = cast_in_segment(connection, scene, rows, hits, options,
                                    deadline_after(connection.timeout)))
    return *std::move(report);
  const auto response =
      send(connection, make_request(scene, rows, hits, options), options, Repeat::kRefusals);
  if (!response) return response.error();
  return read_response(*response, rows.size(), hits);
}

template <class Columns>
Result<AppliedCast> apply_and_cast(const Connection& connection, const std::string& scene,
                                   std::span<const Update> updates, const Columns& rows,
                                   const HitColumns& hits, const CastOptions& options,
                                   const ApplyOptions& apply_options) {
  auto batch = encode_batch(updates, apply_options);
  if (!batch) return batch.error();
  if (const Status checked = check(rows, hits, options); !checked) return checked.error();
  auto request = make_request(scene, rows, hits, options);
  *request.mutable_apply() = *std::move(batch);
  // The batch has an id, so that the server applies it once.
  CastOptions stopped = options;
  if (!stopped.stop.stop_possible()) stopped.stop = apply_options.stop;
  const auto response = send(connection, request, stopped, Repeat::kRefusalsAndBreaks);
  if (!response) return response.error();
  // A server that does not know the updates casts without them.
  if (!response->has_applied()) {
    return Error{Code::kUnimplemented,
                 "the server is of a version that applies no updates with a cast, and has applied "
                 "none",
                 {}};
  }
  const auto report = read_response(*response, rows.size(), hits);
  if (!report) return report.error();
  return AppliedCast{decode(response->applied()), *report};
}

template <class Columns>
Begin<CastReport> async_cast(const std::shared_ptr<const Connection>& connection,
                             const std::string& scene, const Columns& rows, const HitColumns& hits,
                             const CastOptions& options) {
  using Request = RequestOf<Columns>;
  using Response = typename CallsOf<Request>::Response;
  if (const Status checked = check(rows, hits, options); !checked)
    return refused<CastReport>(checked.error());
  return unary_call<CastReport, Request, Response>(
      connection, connection->timeout, Repeat::kRefusals, {scene, options.route_key}, options.stop,
      make_request(scene, rows, hits, options),
      [](const Connection& by, grpc::ClientContext& context, const Request& asked,
         Response& response, std::function<void(grpc::Status)> ended) {
        CallsOf<Request>::begin(*by.queries, context, asked, response, std::move(ended));
      },
      [n = rows.size(), hits](const Response& response) {
        return read_response(response, n, hits);
      });
}

template <class Columns>
Result<CastReport> cast_source(const Connection& connection, const std::string& scene,
                               const RowSource<Columns>& source, typename Columns::Shape shape,
                               HitFields fields, const HitSink& sink, const CastOptions& options) {
  return cast_messages(connection, scene, messages_of<RequestOf<Columns>>(source, shape), fields,
                       sink, options);
}

template <class Columns>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const Columns& rows, const HitColumns& hits,
                               const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const Status checked = check_rows(rows, hits); !checked) return checked.error();
  if (auto report = stream_in_segment(connection, scene, rows, hits, options,
                                      deadline_after(connection.timeout)))
    return *std::move(report);
  return cast_source(connection, scene, source_of(rows), shape_of(rows), fields_of(hits),
                     copy_to(hits), rows.size() == 0 ? without_sides(options) : options);
}

template <class Generator>
Result<CastReport> cast_generated(const Connection& connection, const std::string& scene,
                                  const Generator& generator, HitFields fields, const HitSink& sink,
                                  const CastOptions& options) {
  const auto source = messages_of<RequestOf<Generator>>(generator);
  if (!source) return source.error();
  return cast_messages(connection, scene, *source, fields, sink, options);
}

template <class Generator>
Result<CastReport> cast_generated(const Connection& connection, const std::string& scene,
                                  const Generator& generator, const HitColumns& hits,
                                  const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  const std::uint64_t count = proto::rays::count_of(generator);
  if (const Status checked = check_rows(count, hits); !checked) return checked.error();
  if (auto report = stream_in_segment(connection, scene, generator, hits, options,
                                      deadline_after(connection.timeout)))
    return *std::move(report);
  return cast_generated(connection, scene, generator, fields_of(hits), copy_to(hits),
                        count == 0 ? without_sides(options) : options);
}

template <class Columns>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const Columns& rows, HitFields fields, CastOptions options) {
  if (const Status checked = check_rows(rows, HitColumns{}); !checked) return checked.error();
  options.kind = QueryKind::kAll;
  AllHits all;
  const HitSink sink = [&](std::uint64_t, std::size_t, const HitView& answers) {
    all.append(answers);
    return Status();
  };
  const auto report =
      cast_source(connection, scene, source_of(rows), shape_of(rows), fields, sink, options);
  if (!report) return report.error();
  all.report = *report;
  return all;
}

template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const float>&, const HitColumns&,
                                 const CastOptions&);
template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const double>&, const HitColumns&,
                                 const CastOptions&);
template Result<CastReport> cast(const Connection&, const std::string&,
                                 const PointColumns<const float>&, const HitColumns&,
                                 const CastOptions&);
template Result<CastReport> cast(const Connection&, const std::string&,
                                 const PointColumns<const double>&, const HitColumns&,
                                 const CastOptions&);

template Result<AppliedCast> apply_and_cast(const Connection&, const std::string&,
                                            std::span<const Update>, const RayColumns<const float>&,
                                            const HitColumns&, const CastOptions&,
                                            const ApplyOptions&);
template Result<AppliedCast> apply_and_cast(const Connection&, const std::string&,
                                            std::span<const Update>,
                                            const RayColumns<const double>&, const HitColumns&,
                                            const CastOptions&, const ApplyOptions&);
template Result<AppliedCast> apply_and_cast(const Connection&, const std::string&,
                                            std::span<const Update>,
                                            const PointColumns<const float>&, const HitColumns&,
                                            const CastOptions&, const ApplyOptions&);
template Result<AppliedCast> apply_and_cast(const Connection&, const std::string&,
                                            std::span<const Update>,
                                            const PointColumns<const double>&, const HitColumns&,
                                            const CastOptions&, const ApplyOptions&);
template Begin<CastReport> async_cast(const std::shared_ptr<const Connection>&, const std::string&,
                                      const RayColumns<const float>&, const HitColumns&,
                                      const CastOptions&);
template Begin<CastReport> async_cast(const std::shared_ptr<const Connection>&, const std::string&,
                                      const RayColumns<const double>&, const HitColumns&,
                                      const CastOptions&);
template Begin<CastReport> async_cast(const std::shared_ptr<const Connection>&, const std::string&,
                                      const PointColumns<const float>&, const HitColumns&,
                                      const CastOptions&);
template Begin<CastReport> async_cast(const std::shared_ptr<const Connection>&, const std::string&,
                                      const PointColumns<const double>&, const HitColumns&,
                                      const CastOptions&);

template Result<CastReport> cast_source(const Connection&, const std::string&,
                                        const RaySource<float>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_source(const Connection&, const std::string&,
                                        const RaySource<double>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_source(const Connection&, const std::string&,
                                        const PointSource<float>&, PointShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_source(const Connection&, const std::string&,
                                        const PointSource<double>&, PointShape, HitFields,
                                        const HitSink&, const CastOptions&);

template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const float>&, const HitColumns&,
                                        const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const double>&, const HitColumns&,
                                        const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const PointColumns<const float>&, const HitColumns&,
                                        const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const PointColumns<const double>&, const HitColumns&,
                                        const CastOptions&);

template Result<CastReport> cast_generated(const Connection&, const std::string&,
                                           const RayGenerator&, HitFields, const HitSink&,
                                           const CastOptions&);
template Result<CastReport> cast_generated(const Connection&, const std::string&,
                                           const RayGenerator&, const HitColumns&,
                                           const CastOptions&);
template Result<CastReport> cast_generated(const Connection&, const std::string&, const PointGrid&,
                                           HitFields, const HitSink&, const CastOptions&);
template Result<CastReport> cast_generated(const Connection&, const std::string&, const PointGrid&,
                                           const HitColumns&, const CastOptions&);

template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const float>&, HitFields, CastOptions);
template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const double>&, HitFields, CastOptions);
template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const PointColumns<const float>&, HitFields, CastOptions);
template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const PointColumns<const double>&, HitFields, CastOptions);

}  // namespace sightline::client::calls
