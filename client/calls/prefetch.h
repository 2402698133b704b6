// Builds trees before rays come. Internal to the library.
#pragma once

#include <string>

#include "client/prefetch.h"
#include "client/ray_generator.h"
#include "client/result.h"

namespace sightline::client::calls {

struct Connection;

Result<PrefetchReport> prefetch(const Connection& connection, const std::string& scene,
                                const PrefetchOptions& options, const PrefetchProgress& progress);

// Scalar is float or double.
template <class Scalar>
Result<PrefetchReport> prefetch_rays(const Connection& connection, const std::string& scene,
                                     const RaySource<Scalar>& source, RayShape shape,
                                     const PrefetchOptions& options,
                                     const PrefetchProgress& progress);
template <class Scalar>
Result<PrefetchReport> prefetch_rays(const Connection& connection, const std::string& scene,
                                     const RayColumns<const Scalar>& rays,
                                     const PrefetchOptions& options,
                                     const PrefetchProgress& progress);
Result<PrefetchReport> prefetch_rays(const Connection& connection, const std::string& scene,
                                     const RayGenerator& generator, const PrefetchOptions& options,
                                     const PrefetchProgress& progress);

}  // namespace sightline::client::calls
