// Casts rays in one message, or in those of a stream.
#include "client/calls/cast.h"

#include <algorithm>
#include <cstdint>

#include "client/calls/cast_stream.h"
#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/message_source.h"
#include "client/calls/retries.h"
#include "client/wire/cast_codec.h"

namespace sightline::client::calls {

template <class Scalar>
Result<CastReport> cast(const Connection& connection, const std::string& scene,
                        const RayColumns<const Scalar>& rays, const HitColumns& hits,
                        const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const Status checked = check_rows(rays, hits); !checked) return checked.error();
  const HitFields fields = fields_of(hits);
  v1::CastRaysRequest request;
  wire::describe(scene, fields, options, request);
  copy_rays(rays, 0,
            wire::resize_columns<Scalar>(rays.size(), shape_of(rays), *request.mutable_rays()));

  const auto deadline = deadline_after(connection.timeout);
  Retries retries(deadline);
  v1::CastRaysResponse response;
  while (true) {
    grpc::ClientContext context;
    if (deadline) context.set_deadline(*deadline);
    set_route(context, scene, options.route_key);
    const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
    const grpc::Status status = connection.queries->CastRays(&context, request, &response);
    if (status.ok()) break;
    if (!retries.wait(status, options.stop)) return rpc_error(status);
  }
  const auto answers = wire::view_hits(response, fields, rays.size());
  if (!answers) return answers.error();
  std::fill(hits.unanswered.begin(), hits.unanswered.end(), std::uint8_t{0});
  copy_hits(*answers, 0, hits);
  CastReport report;
  wire::add_stats(response, report);
  return report;
}

template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const float>&, const HitColumns&,
                                 const CastOptions&);
template Result<CastReport> cast(const Connection&, const std::string&,
                                 const RayColumns<const double>&, const HitColumns&,
                                 const CastOptions&);

namespace {

HitSink copy_to(const HitColumns& hits) {
  std::fill(hits.unanswered.begin(), hits.unanswered.end(), std::uint8_t{0});
  return [&hits](std::uint64_t first, std::size_t, const HitView& answers) {
    copy_hits(answers, first, hits);
    return Status();
  };
}

}  // namespace

template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RaySource<Scalar>& source, RayShape shape, HitFields fields,
                               const HitSink& sink, const CastOptions& options) {
  return cast_messages(connection, scene, messages_of<v1::CastRaysRequest>(source, shape), fields,
                       sink, options);
}

Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, HitFields fields, const HitSink& sink,
                               const CastOptions& options) {
  const auto source = messages_of<v1::CastRaysRequest>(generator);
  if (!source) return source.error();
  return cast_messages(connection, scene, *source, fields, sink, options);
}

Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, const HitColumns& hits,
                               const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  if (const Status checked = check_rows(proto::rays::count_of(generator), hits); !checked)
    return checked.error();
  return cast_stream(connection, scene, generator, fields_of(hits), copy_to(hits), options);
}

template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayColumns<const Scalar>& rays, const HitColumns& hits,
                               const CastOptions& options) {
  if (const Status checked = check_kind(options.kind); !checked) return checked.error();
  if (const Status checked = check_rows(rays, hits); !checked) return checked.error();
  return cast_stream<Scalar>(connection, scene, source_of(rays), shape_of(rays), fields_of(hits),
                             copy_to(hits), options);
}

template <class Scalar>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const RayColumns<const Scalar>& rays, HitFields fields,
                         CastOptions options) {
  if (const Status checked = check_rows(rays, HitColumns{}); !checked) return checked.error();
  options.kind = QueryKind::kAll;
  AllHits all;
  const HitSink sink = [&](std::uint64_t, std::size_t, const HitView& answers) {
    all.append(answers);
    return Status();
  };
  const auto report = cast_stream<Scalar>(connection, scene, source_of(rays), shape_of(rays),
                                          fields, sink, options);
  if (!report) return report.error();
  all.report = *report;
  return all;
}

template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RaySource<float>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RaySource<double>&, RayShape, HitFields,
                                        const HitSink&, const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const float>&, const HitColumns&,
                                        const CastOptions&);
template Result<CastReport> cast_stream(const Connection&, const std::string&,
                                        const RayColumns<const double>&, const HitColumns&,
                                        const CastOptions&);

template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const float>&, HitFields, CastOptions);
template Result<AllHits> cast_all(const Connection&, const std::string&,
                                  const RayColumns<const double>&, HitFields, CastOptions);

}  // namespace sightline::client::calls
