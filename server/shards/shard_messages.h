// The messages between servers that answer for shards.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/query/shard_merge.h"
#include "scenegraph/side_rule.h"
#include "scenegraph/trace_options.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::shards {

struct RayMessages {
  v1::CastRaysRequest request;
  v1::CastRaysResponse reply;
};
struct PointMessages {
  v1::QueryPointsRequest request;
  v1::QueryPointsResponse reply;
};
/// A question to a peer, and its answer.
using Messages = std::variant<RayMessages, PointMessages>;

/// What the requests of a call have in common: what `asked` asks for, of this kind and with
/// `surface` (barycentrics and normals) or without, and the fields that a merge needs. Neither
/// rays, nor the revision, nor the shard.
v1::CastRaysRequest make_template(const v1::CastRaysRequest& asked, scenegraph::QueryKind kind,
                                  bool surface);
v1::QueryPointsRequest make_template(const v1::QueryPointsRequest& asked,
                                     scenegraph::QueryKind kind, bool surface);
/// The same for questions to which decode_sides() reads the answers.
v1::QueryPointsRequest make_side_template(const v1::QueryPointsRequest& asked,
                                          const scenegraph::SideQuestion& sides);

/// A ray of the batch as it is asked.
using RayOf = std::function<accel::geometry::Ray(std::uint32_t ray)>;

/// Sets the rays or points of the question.
void set_rays(const RayOf& ray_of, const scenegraph::query::ShardQuestion& question,
              v1::CastRaysRequest& request);
void set_rays(const RayOf& ray_of, const scenegraph::query::ShardQuestion& question,
              v1::QueryPointsRequest& request);

using HitColumns = google::protobuf::RepeatedPtrField<v1::HitColumn>;

/// The hits of a reply.
struct ShardAnswer {
  std::vector<accel::geometry::Hit> hits;     ///< Closest, any: one for each ray; all: the listed.
  std::vector<scenegraph::RayTally> tallies;  ///< Count and all: one for each ray.
};

/// Reads the columns of a reply. Errors: kInternal, naming the column, if it has not what
/// make_template() asks for.
Result<ShardAnswer> decode(const HitColumns& columns, scenegraph::QueryKind kind, std::size_t rays);

/// The sides in a reply, see ShardSides::take().
struct ShardSideAnswer {
  std::vector<scenegraph::Side> sides;
  std::vector<std::uint32_t> crossings;
};

/// Reads the columns of a reply to make_side_template(). Errors: as decode().
Result<ShardSideAnswer> decode_sides(const HitColumns& columns,
                                     const scenegraph::SideQuestion& question, std::size_t points);

/// What the reply cost. The counts of rays and hits are not in it: the merge has those.
scenegraph::TraceStats decode_cost(const v1::CastStats& stats);

}  // namespace sightline::server::shards
