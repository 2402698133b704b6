// One batch of rays in one message.
#include "client/calls/cast.h"

#include "client/calls/channel.h"
#include "client/calls/columns.h"
#include "client/calls/connection.h"
#include "client/calls/rpc_error.h"
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
  copy_rays(rays, 0, wire::make_room<Scalar>(rays.size(), shape_of(rays), *request.mutable_rays()));

  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  v1::CastRaysResponse response;
  const grpc::Status status = connection.queries->CastRays(&context, request, &response);
  if (!status.ok()) return rpc_error(status);
  const auto answers = wire::view_hits(response, fields, rays.size());
  if (!answers) return answers.error();
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

}  // namespace sightline::client::calls
