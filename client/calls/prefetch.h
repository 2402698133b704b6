// Builds trees before rays come. Internal to the library.
#pragma once

#include <memory>
#include <string>

#include "client/calls/unary_call.h"
#include "client/points.h"
#include "client/prefetch.h"
#include "client/ray_generator.h"
#include "client/result.h"

namespace sightline::client::calls {

Result<PrefetchReport> prefetch(const Connection& connection, const std::string& scene,
                                const PrefetchOptions& options, const PrefetchProgress& progress);
/// As prefetch(), begun later. gRPC's threads call `progress`.
Begin<PrefetchReport> async_prefetch(const std::shared_ptr<const Connection>& connection,
                                     const std::string& scene, const PrefetchOptions& options,
                                     PrefetchProgress progress);

/// Columns are RayColumns or PointColumns of float or double.
template <class Columns>
Result<PrefetchReport> prefetch_rows(const Connection& connection, const std::string& scene,
                                     const RowSource<Columns>& source,
                                     typename Columns::Shape shape, const PrefetchOptions& options,
                                     const PrefetchProgress& progress);
/// Rows are RayColumns or PointColumns of const float or const double.
template <class Rows>
Result<PrefetchReport> prefetch_columns(const Connection& connection, const std::string& scene,
                                        const Rows& rows, const PrefetchOptions& options,
                                        const PrefetchProgress& progress);
/// Generator is RayGenerator or PointGrid.
template <class Generator>
Result<PrefetchReport> prefetch_made(const Connection& connection, const std::string& scene,
                                     const Generator& generator, const PrefetchOptions& options,
                                     const PrefetchProgress& progress);

}  // namespace sightline::client::calls
