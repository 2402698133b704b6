// Casts rays, or asks for the faces nearest to points, in one message or over a stream. Internal to
// the library.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "client/calls/unary_call.h"
#include "client/cast_options.h"
#include "client/client.h"
#include "client/points.h"
#include "client/ray_generator.h"
#include "client/result.h"
#include "client/update.h"

namespace sightline::client::calls {

// Columns are RayColumns or PointColumns, of const float or const double; those of a source are not
// const. A generator is a RayGenerator or a PointGrid.
template <class Columns>
Result<CastReport> cast(const Connection& connection, const std::string& scene, const Columns& rows,
                        const HitColumns& hits, const CastOptions& options);
/// As cast(), begun later. Copies `rows`; the arrays of `hits` must live until it is done.
template <class Columns>
Begin<CastReport> async_cast(const std::shared_ptr<const Connection>& connection,
                             const std::string& scene, const Columns& rows, const HitColumns& hits,
                             const CastOptions& options);
template <class Columns>
Result<AppliedCast> apply_and_cast(const Connection& connection, const std::string& scene,
                                   std::span<const Update> updates, const Columns& rows,
                                   const HitColumns& hits, const CastOptions& options,
                                   const ApplyOptions& apply_options);
template <class Columns>
Result<CastReport> cast_source(const Connection& connection, const std::string& scene,
                               const RowSource<Columns>& source, typename Columns::Shape shape,
                               HitFields fields, const HitSink& sink, const CastOptions& options);
template <class Columns>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const Columns& rows, const HitColumns& hits,
                               const CastOptions& options);

template <class Generator>
Result<CastReport> cast_generated(const Connection& connection, const std::string& scene,
                                  const Generator& generator, HitFields fields, const HitSink& sink,
                                  const CastOptions& options);
template <class Generator>
Result<CastReport> cast_generated(const Connection& connection, const std::string& scene,
                                  const Generator& generator, const HitColumns& hits,
                                  const CastOptions& options);

template <class Columns>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const Columns& rows, HitFields fields, CastOptions options);

}  // namespace sightline::client::calls
