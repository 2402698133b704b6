// Columns of a reply that follow from others: positions from t, names from nodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace.h"
#include "server/queries/cast_query.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// The most bytes of names in one reply, on the wire.
inline constexpr std::size_t kMaxNameBytes = std::size_t{2} << 20;

/// Most bytes that positions and names add to columns of `rows` rows, for `hits` hits, whose names
/// are kept.
std::size_t derived_bytes(const CastQuery& query, std::size_t rows, std::size_t hits);

/// Writes the columns of one reply after the other.
class DerivedColumns {
 public:
  /// Begins a reply, which gets the names, and columns of their final size. These, and the
  /// revision, outlive its rows. `points`: whether the rays are points.
  void begin(const scenegraph::revision::Snapshot& snapshot, bool points,
             v1::CastRaysResponse& columns, v1::CastRaysResponse& reply);

  /// Gives `hits` the fields that the columns follow from and that are not asked for, until the
  /// next call.
  void add_sources(accel::geometry::HitColumns& hits);

  /// Writes a row for each ray, from row `first` on. `hits` has had add_sources(), and its fields
  /// are set. Errors: kResourceExhausted, over kMaxNameBytes.
  Status write(const accel::geometry::RayColumns& rays, const accel::geometry::HitColumns& hits,
               std::size_t first);

  /// Writes a row for each listed hit: those of each ray after those of the ray before. Errors: as
  /// write().
  Status write_lists(std::span<const accel::geometry::Ray> rays,
                     std::span<const scenegraph::RayTally> tallies,
                     std::span<const accel::geometry::Hit> hits);

  /// Frees what was kept to find the names of the last reply.
  void end();

 private:
  void set_position(std::size_t row, const accel::geometry::Ray& ray,
                    const accel::geometry::Hit& hit);
  Status set_name(std::size_t row, scenegraph::model::NodeId node);
  Result<std::uint32_t> find_or_add_name(scenegraph::model::NodeId node);

  const scenegraph::revision::Snapshot* snapshot_ = nullptr;
  v1::CastRaysResponse* reply_ = nullptr;
  bool points_ = false;
  // Columns of the reply; null: not asked for.
  std::string* positions_ = nullptr;
  std::string* names_ = nullptr;
  // Sources that are not asked for.
  std::vector<double> t_;
  std::vector<scenegraph::model::NodeId> nodes_;
  std::vector<std::uint32_t> primitives_;
  // Rows of the reply's names. The keys are names in the revision.
  std::unordered_map<scenegraph::model::NodeId, std::uint32_t> row_of_node_;
  std::unordered_map<std::string_view, std::uint32_t> row_of_name_;
  std::size_t name_bytes_ = 0;
};

}  // namespace sightline::server::queries
