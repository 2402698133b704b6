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

namespace sightline::server {

/// With every field asked for, the reply to so many rays stays below 1 MiB.
inline constexpr std::size_t kMaxRaysPerRequest = 16384;

/// What a cast asks for, but for its rays.
struct CastQuery {
  scenegraph::QueryKind kind = scenegraph::QueryKind::kClosest;
  scenegraph::Growth growth = scenegraph::Growth::kFirstTouch;
  std::vector<v1::HitField> fields;  ///< Columns of the reply, in this order; no field twice.
  bool surface = false;              ///< Whether barycentrics or normals are among them.
};

/// `policy` is what an unspecified build mode means.
/// Errors: kInvalidArgument (a kind, field or build mode that is not known, a field asked for
/// twice, a field that the kind does not have).
Result<CastQuery> decode_query(const v1::CastRaysRequest& request, scenegraph::Growth policy);

/// Fills `rays`, whose memory is used again, from little-endian columns. Values are not looked at:
/// an invalid ray is the tracer's to mark. Errors: kInvalidArgument, naming the column, its bytes
/// and the bytes expected; kResourceExhausted over kMaxRaysPerRequest.
Status decode_rays(const v1::Rays& columns, std::vector<accel::Ray>& rays);

/// Sets the reply's columns, one per field. What the reply held before is overwritten, its memory
/// used again.
void encode_hits(std::span<const accel::Hit> hits, std::span<const v1::HitField> fields,
                 v1::CastRaysResponse& reply);

/// Sets all of CastStats but the two times only the caller knows (queue_us, trace_us).
void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply);

}  // namespace sightline::server
