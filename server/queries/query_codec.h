// Ray batches between the wire and the tracer. With scene_codec the only place that sees messages
// and plain structs.
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

/// With every field asked for, the reply to so many rays stays below 1 MiB.
inline constexpr std::size_t kMaxRaysPerRequest = 16384;
/// The same of the hits that a reply lists, for as many rays.
inline constexpr std::size_t kMaxHitsPerReply = 20480;

/// Fills `rays`, whose memory is used again, from little-endian columns. Values are not looked at:
/// an invalid ray is the tracer's to mark. Errors: kInvalidArgument, naming the column, its bytes
/// and the bytes expected; kResourceExhausted over kMaxRaysPerRequest.
Status decode_rays(const v1::Rays& columns, std::vector<accel::geometry::Ray>& rays);

/// Sets the reply's columns, one per field. What the reply held before is overwritten, its memory
/// used again.
void encode_hits(std::span<const accel::geometry::Hit> hits, std::span<const v1::HitField> fields,
                 v1::CastRaysResponse& reply);

/// The same for kinds whose rays have a tally: fields of rays are taken from `tallies`, fields of
/// hits from `hits`.
void encode_tallies(std::span<const scenegraph::RayTally> tallies,
                    std::span<const accel::geometry::Hit> hits,
                    std::span<const v1::HitField> fields, v1::CastRaysResponse& reply);

/// Sets all of CastStats but the two times only the caller knows (queue_us, trace_us).
void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply);

}  // namespace sightline::server::queries
