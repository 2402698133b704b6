// Columns of a reply that tell on which side of the scene's surfaces points are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/sides.h"
#include "server/queries/cast_query.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// Most bytes that the sides of the query, which asks for some, add to a reply of `points`, and to
/// a slice of it.
std::size_t side_bytes(const CastQuery& query, std::size_t points, std::size_t slice);

/// Writes the columns of one reply after the other.
class SideColumns {
 public:
  /// Begins a reply to `points`, which outlives its rows. Its columns have their final size, but
  /// for crossings, which get it here.
  void begin(v1::CastRaysResponse& reply, const CastQuery& query, std::size_t points);

  /// Gives `hits` the distances that signed ones follow from, if those are not asked for.
  void add_sources(accel::geometry::HitColumns& hits);

  /// Finds the sides of these points, and writes a row for each, from row `first` on. `hits` has
  /// had add_sources(), and its fields are set. Errors and stats: as find_sides().
  Result<scenegraph::TraceStats> write(const scenegraph::revision::Snapshot& snapshot,
                                       const accel::geometry::RayColumns& points,
                                       const scenegraph::SideQuestion& question,
                                       const scenegraph::TraceOptions& options,
                                       const accel::geometry::HitColumns& hits, std::size_t first);

  /// Writes these sides and votes in the same way, but no crossings.
  void write(std::span<const scenegraph::Side> sides, std::span<const std::uint8_t> votes,
             const accel::geometry::HitColumns& hits, std::size_t first);

  /// Those of the last write() of a revision's.
  std::span<const scenegraph::Side> sides() const { return sides_; }

 private:
  // Columns of the reply; null: not asked for.
  std::string *signed_ = nullptr, *inside_ = nullptr, *votes_ = nullptr, *crossings_ = nullptr;
  std::vector<double> t_;  // if it is not asked for
  std::vector<scenegraph::Side> sides_;
  std::vector<std::uint8_t> votes_of_;
  std::vector<std::uint32_t> crossings_of_;
};

}  // namespace sightline::server::queries
