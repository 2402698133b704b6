// Decodes ray columns of a request and encodes hit columns of a reply.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/trace.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// With every field, the reply to this many rays stays below 1 MiB.
inline constexpr std::size_t kMaxRaysPerRequest = 16384;
/// With every field, a reply that lists this many hits stays below 1 MiB.
inline constexpr std::size_t kMaxHitsPerReply = 20480;

/// The number of rays, by the lengths of the columns alone. Errors: kInvalidArgument, naming the
/// column, its bytes and the bytes expected; kResourceExhausted over kMaxRaysPerRequest.
Result<std::size_t> count_rays(const v1::Rays& columns);

/// Fills `rays` from little-endian columns and reuses its memory. Values are not checked: the
/// tracer marks invalid rays. Errors: as count_rays().
Status decode_rays(const v1::Rays& columns, std::vector<accel::geometry::Ray>& rays);

/// Sets the reply's columns, one per field. Overwrites what the reply held before and reuses its
/// memory.
void encode_hits(std::span<const accel::geometry::Hit> hits, std::span<const v1::HitField> fields,
                 v1::CastRaysResponse& reply);

/// As encode_hits(), for query kinds with a tally per ray. Fields of rays come from `tallies`,
/// fields of hits from `hits`.
void encode_tallies(std::span<const scenegraph::RayTally> tallies,
                    std::span<const accel::geometry::Hit> hits,
                    std::span<const v1::HitField> fields, v1::CastRaysResponse& reply);

/// Sets all of CastStats except queue_us and trace_us, which only the caller knows.
void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply);

}  // namespace sightline::server::queries
