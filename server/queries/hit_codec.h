// Encodes the hit columns of a reply. DerivedColumns writes those of positions and names.
#pragma once

#include <cstddef>
#include <span>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray.h"
#include "scenegraph/sides.h"
#include "scenegraph/trace.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// With every field, a reply that lists this many hits stays below 2 MiB, without names.
inline constexpr std::size_t kMaxHitsPerReply = 20480;

/// A slice of a batch begins at a multiple of this number of rays: the rays of a byte of HIT_BITS.
inline constexpr std::size_t kRaysPerBitsByte = 8;

/// Bytes of a column with rows for `rays` rays; where it has a row for each hit, for `hits` hits. 0
/// for a field that this file does not size (CROSSINGS).
std::size_t column_bytes(v1::HitField field, std::size_t rays, std::size_t hits);

/// Bytes of a column's element.
std::size_t element_bytes(v1::HitField field);

/// Makes one column per field, in this order, with rows for `rays` rays and, in an answer that
/// lists hits, for `hits` hits; else `hits` is the number of rays. The content of the rows is not
/// defined. Reuses the memory of what the reply held before.
void resize_columns(std::span<const v1::HitField> fields, std::size_t rays, std::size_t hits,
                    v1::CastRaysResponse& reply);

/// The rows of `rays` hits in the columns, from row `first` on, a multiple of kRaysPerBitsByte. The
/// columns have these rows, and are not resized before the hits are written.
accel::geometry::HitColumns view_hits(v1::CastRaysResponse& reply, std::size_t first,
                                      std::size_t rays);

/// Writes the rows of these answers to the columns of a query kind with a tally per ray, from row
/// `first` on. The columns have these rows.
void encode_tallies(std::span<const scenegraph::RayTally> tallies, std::size_t first,
                    v1::CastRaysResponse& reply);

/// Sets the columns to lists of hits, those of each ray after those of the ray before. Overwrites
/// what the reply held before and reuses its memory.
void encode_lists(std::span<const scenegraph::RayTally> tallies,
                  std::span<const accel::geometry::Hit> hits, std::span<const v1::HitField> fields,
                  v1::CastRaysResponse& reply);

/// Sets the bits of the rays of these states that have no answer; the first is ray `first` of
/// `rays` of the reply.
void mark_unanswered(std::span<const accel::geometry::HitState> states, std::size_t first,
                     std::size_t rays, v1::CastRaysResponse& reply);
void mark_unanswered(std::span<const scenegraph::RayTally> tallies, std::size_t first,
                     std::size_t rays, v1::CastRaysResponse& reply);
void mark_unanswered(std::span<const scenegraph::Side> sides, std::size_t first, std::size_t rays,
                     v1::CastRaysResponse& reply);

/// Sets all of CastStats except queue_us and trace_us, which only the caller knows.
void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply);

}  // namespace sightline::server::queries
