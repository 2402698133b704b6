// The query of a cast: everything except its rays or points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "accel/geometry/facing.h"
#include "proto/result.h"
#include "scenegraph/model/node.h"
#include "scenegraph/query/label_filter.h"
#include "scenegraph/sides.h"
#include "scenegraph/trace_options.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

inline constexpr std::uint32_t kDefaultMaxHits = 256;
/// One message with every field holds this many hits.
inline constexpr std::uint32_t kMaxMaxHits = 16384;
inline constexpr int kMaxExclusions = 4096;
inline constexpr int kMaxLabelMatches = 64;  ///< Of only_labels, and of exclude_labels.

/// A range of the scene: the message Shard, decoded.
struct ShardOf {
  std::uint32_t index = 0, count = 0;
  std::uint64_t cut = 0;  ///< 0: not checked.
};

/// A checked query.
struct CastQuery {
  scenegraph::QueryKind kind = scenegraph::QueryKind::kClosest;
  scenegraph::Growth growth = scenegraph::Growth::kFirstTouch;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  scenegraph::model::NodeId root = 0;                 ///< 0: the whole scene.
  std::vector<scenegraph::model::NodeId> excluded{};  ///< Not checked against the scene yet.
  scenegraph::query::LabelFilter labels{};
  std::uint32_t max_hits = kDefaultMaxHits;
  /// Columns of the answer, in this order; no field twice.
  std::vector<v1::HitField> fields{};
  bool in_segment = false;  ///< Whether they go to a segment, else into the reply.
  bool surface = false;     ///< Whether `fields` has barycentrics or normals.
  bool positions = false;   ///< Whether `fields` has positions.
  bool names = false;       ///< Whether `fields` has names.

  std::optional<ShardOf> shard{};  ///< Only what is in it exists. Unset: everything.
  bool allow_partial = false;
  bool points = false;  ///< Whether it asks for the faces nearest to points.
  /// How the sides of points are found, if `fields` has signed distances, insides, votes or
  /// crossings.
  std::optional<scenegraph::SideQuestion> sides{};
  bool sides_alone = false;  ///< Whether `fields` has nothing that needs the nearest faces.
  bool crossings = false;    ///< Whether `fields` has crossings.

  bool selects() const { return root != 0 || !excluded.empty() || !labels.sees_all() || shard; }
};

/// Checks and decodes the query. `policy` is used for an unspecified build mode. Errors:
/// kInvalidArgument (an unknown kind, field, build mode or culling; a repeated field; a field or
/// limit that the kind does not have; a number or rule of sides that does not exist, or without
/// their fields; crossings without a shard; columns for a segment beside fields, or of a kind or
/// field that does not go there; kMaxMaxHits, kMaxExclusions or kMaxLabelMatches exceeded; a label
/// that no node can have; a shard whose index is not below its count).
Result<CastQuery> decode_query(const v1::CastRaysRequest& request, scenegraph::Growth policy);
Result<CastQuery> decode_query(const v1::QueryPointsRequest& request, scenegraph::Growth policy);

}  // namespace sightline::server::queries
