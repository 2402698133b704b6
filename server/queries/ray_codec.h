// Decodes the ray columns of a request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "accel/geometry/ray.h"
#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// With every field, the reply to this many rays stays below 2 MiB, and its names below
/// kMaxNameBytes beside them: clients of gRPC take 4 MiB unless they are told otherwise.
inline constexpr std::size_t kMaxRaysPerRequest = 16384;
/// The most rays of a request whose answers go to a segment, and whose rays come from one or are
/// made: no message has to hold either. The fixed cost of a request is then a nanosecond a ray.
inline constexpr std::size_t kMaxSharedRays = 262'144;

/// kMaxSharedRays, or less where a server takes few rays at a time: a quarter of them, so that one
/// request leaves room for others.
std::size_t max_shared_rays(std::uint64_t max_rays_queued);

/// The number of rays, by the lengths of the columns alone. Errors: kInvalidArgument, naming the
/// column, its bytes and the bytes expected, or both numbers of rays where the request says another
/// one; kResourceExhausted over kMaxRaysPerRequest.
Result<std::size_t> count_rays(const v1::Rays& columns);

/// Errors: kResourceExhausted over `most`.
Status check_count(std::uint64_t rays, std::size_t most = kMaxRaysPerRequest);

/// Checks that a column has `count` elements of `bytes` each. `by` names the column that tells
/// their number, `elements` what they are ("rays"). Errors: kInvalidArgument.
Status check_column(std::string_view name, const std::string& column, std::size_t count,
                    std::size_t bytes, std::string_view elements, std::string_view by);

/// A view of `count` rays from `first` on. count_rays() has accepted the columns, which must
/// outlive the view, and these rays are theirs. Values are not checked: the tracer marks invalid
/// rays.
accel::geometry::RayColumns view_rays(const v1::Rays& columns, std::size_t first,
                                      std::size_t count);

/// Fills `rays` with those of view_rays(), as far as it has room.
void decode_rays(const v1::Rays& columns, std::size_t first, std::span<accel::geometry::Ray> rays);

}  // namespace sightline::server::queries
