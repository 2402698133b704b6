// Casts rays in one message, or over a stream. Internal to the library.
#pragma once

#include <string>

#include "client/cast_options.h"
#include "client/ray_generator.h"
#include "client/result.h"

namespace sightline::client::calls {

struct Connection;

// Scalar is float or double.
template <class Scalar>
Result<CastReport> cast(const Connection& connection, const std::string& scene,
                        const RayColumns<const Scalar>& rays, const HitColumns& hits,
                        const CastOptions& options);
template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RaySource<Scalar>& source, RayShape shape, HitFields fields,
                               const HitSink& sink, const CastOptions& options);
template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayColumns<const Scalar>& rays, const HitColumns& hits,
                               const CastOptions& options);

Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, HitFields fields, const HitSink& sink,
                               const CastOptions& options);
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayGenerator& generator, const HitColumns& hits,
                               const CastOptions& options);

template <class Scalar>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const RayColumns<const Scalar>& rays, HitFields fields,
                         CastOptions options);

}  // namespace sightline::client::calls
