// The query of a cast: checks each value, and that the kind has it.
#include "server/queries/cast_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>

#include "scenegraph/query/shard_cut.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

using accel::geometry::Culling;
using scenegraph::Growth;
using scenegraph::QueryKind;

Result<QueryKind> decode_kind(v1::QueryKind kind) {
  switch (kind) {
    case v1::QUERY_KIND_UNSPECIFIED:
    case v1::QUERY_KIND_CLOSEST:
      return QueryKind::kClosest;
    case v1::QUERY_KIND_ANY:
      return QueryKind::kAny;
    case v1::QUERY_KIND_COUNT:
      return QueryKind::kCount;
    case v1::QUERY_KIND_ALL:
      return QueryKind::kAll;
    default:
      return exec::invalid_argument(
          fmt::format("query kind {} is not known", static_cast<int>(kind)), "UNKNOWN_KIND");
  }
}

Result<Growth> decode_growth(v1::BuildMode build, Growth policy) {
  switch (build) {
    case v1::BUILD_MODE_UNSPECIFIED:
      return policy;
    case v1::BUILD_MODE_LAZY:
      return policy == Growth::kDemand ? Growth::kDemand : Growth::kFirstTouch;
    case v1::BUILD_MODE_FULL:
      return Growth::kFull;
    case v1::BUILD_MODE_NONE:
      return Growth::kNone;
    case v1::BUILD_MODE_BUILT_ONLY:
      return Growth::kBuiltOnly;
    default:
      return exec::invalid_argument(
          fmt::format("build mode {} is not known", static_cast<int>(build)), "UNKNOWN_BUILD_MODE");
  }
}

Result<Culling> decode_culling(v1::Culling culling) {
  switch (culling) {
    case v1::CULLING_UNSPECIFIED:
    case v1::CULLING_NONE:
      return Culling::kNone;
    case v1::CULLING_BACK:
      return Culling::kBack;
    case v1::CULLING_FRONT:
      return Culling::kFront;
    default:
      return exec::invalid_argument(
          fmt::format("culling {} is not known", static_cast<int>(culling)), "UNKNOWN_CULLING");
  }
}

/// Fields of a query kind. `always` comes first in every reply, but bits replace HIT; `standard` is
/// used for a request without fields.
struct FieldsOfKind {
  std::vector<v1::HitField> always, standard, optional;
};

const FieldsOfKind& fields_of(QueryKind kind) {
  static const FieldsOfKind kClosest{
      {},
      {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE},
      {v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK,
       v1::HIT_FIELD_POSITION, v1::HIT_FIELD_NAME}};
  static const FieldsOfKind kAny{
      {v1::HIT_FIELD_HIT}, {}, {v1::HIT_FIELD_HIT_BITS, v1::HIT_FIELD_WORK}};
  static const FieldsOfKind kCount{
      {v1::HIT_FIELD_COUNT}, {}, {v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK}};
  static const FieldsOfKind kAll{{v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT},
                                 {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE},
                                 {v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL,
                                  v1::HIT_FIELD_WORK, v1::HIT_FIELD_POSITION, v1::HIT_FIELD_NAME}};
  switch (kind) {
    case QueryKind::kAny:
      return kAny;
    case QueryKind::kCount:
      return kCount;
    case QueryKind::kAll:
      return kAll;
    case QueryKind::kClosest:
      break;
  }
  return kClosest;
}

bool contains(std::span<const v1::HitField> fields, v1::HitField field) {
  return std::find(fields.begin(), fields.end(), field) != fields.end();
}

Status check_field(v1::HitField field, const FieldsOfKind& of_kind, v1::QueryKind kind,
                   std::span<const v1::HitField> before) {
  if (!v1::HitField_IsValid(field) || field == v1::HIT_FIELD_UNSPECIFIED) {
    return exec::invalid_argument(fmt::format("hit field {} is not known", static_cast<int>(field)),
                                  "UNKNOWN_FIELD");
  }
  if (contains(before, field))
    return exec::invalid_argument(fmt::format("{} is asked for twice", v1::HitField_Name(field)),
                                  "FIELD_TWICE");
  if (!contains(of_kind.always, field) && !contains(of_kind.standard, field) &&
      !contains(of_kind.optional, field)) {
    const std::string name =
        v1::QueryKind_Name(kind == v1::QUERY_KIND_UNSPECIFIED ? v1::QUERY_KIND_CLOSEST : kind);
    return exec::invalid_argument(fmt::format("{} has no {}", name, v1::HitField_Name(field)),
                                  "FIELD_NOT_OF_KIND");
  }
  return {};
}

template <class Request>
Status decode_fields(const Request& request, CastQuery& query) {
  const FieldsOfKind& of_kind = fields_of(query.kind);
  std::vector<v1::HitField> asked;
  for (const int number : request.fields()) {
    const auto field = static_cast<v1::HitField>(number);
    if (Status good = check_field(field, of_kind, request.kind(), asked); !good) return good;
    asked.push_back(field);
  }
  for (const v1::HitField field : of_kind.always) {
    const bool in_bits = field == v1::HIT_FIELD_HIT && contains(asked, v1::HIT_FIELD_HIT_BITS);
    if (!in_bits && !contains(asked, field)) query.fields.push_back(field);
  }
  const std::vector<v1::HitField>& others = asked.empty() ? of_kind.standard : asked;
  query.fields.insert(query.fields.end(), others.begin(), others.end());
  query.surface = contains(query.fields, v1::HIT_FIELD_BARYCENTRIC) ||
                  contains(query.fields, v1::HIT_FIELD_NORMAL);
  query.positions = contains(query.fields, v1::HIT_FIELD_POSITION);
  query.names = contains(query.fields, v1::HIT_FIELD_NAME);
  return {};
}

template <class Request>
Status decode_max_hits(const Request& request, CastQuery& query) {
  if (request.max_hits() == 0) return {};
  if (query.kind != QueryKind::kAll) {
    return exec::invalid_argument(
        fmt::format("max_hits is {}, but only QUERY_KIND_ALL has it", request.max_hits()),
        "LIMIT_NOT_OF_KIND");
  }
  if (request.max_hits() > kMaxMaxHits) {
    return exec::invalid_argument(
        fmt::format("max_hits is {}, the limit is {}", request.max_hits(), kMaxMaxHits),
        "MAX_HITS_TOO_LARGE");
  }
  query.max_hits = request.max_hits();
  return {};
}

template <class Request>
Status decode_nodes(const Request& request, CastQuery& query) {
  if (request.exclude_size() > kMaxExclusions) {
    return exec::invalid_argument(
        fmt::format("{} nodes are excluded, the limit is {}; exclude a parent of them",
                    request.exclude_size(), kMaxExclusions),
        "TOO_MANY_EXCLUSIONS");
  }
  query.root = request.root();
  query.excluded.assign(request.exclude().begin(), request.exclude().end());
  return {};
}

template <class Request>
Status decode_shard(const Request& request, CastQuery& query) {
  query.allow_partial = request.allow_partial();
  if (!request.has_shard()) return {};
  const v1::Shard& shard = request.shard();
  if (shard.count() > scenegraph::query::kMaxShards || shard.index() >= shard.count()) {
    return exec::invalid_argument(
        fmt::format("shard {} of {}: an index is below the count, and that is at most {}",
                    shard.index(), shard.count(), scenegraph::query::kMaxShards),
        "BAD_SHARD");
  }
  query.shard = {shard.index(), shard.count(), shard.cut()};
  return {};
}

/// Everything but culling.
template <class Request>
Result<CastQuery> decode_common(const Request& request, Growth policy) {
  const auto kind = decode_kind(request.kind());
  if (!kind) return kind.error();
  const auto growth = decode_growth(request.build(), policy);
  if (!growth) return growth.error();
  CastQuery query{.kind = *kind, .growth = *growth};
  if (const Status good = decode_fields(request, query); !good) return good.error();
  if (const Status good = decode_max_hits(request, query); !good) return good.error();
  if (const Status good = decode_nodes(request, query); !good) return good.error();
  if (const Status good = decode_shard(request, query); !good) return good.error();
  return query;
}

}  // namespace

Result<CastQuery> decode_query(const v1::CastRaysRequest& request, Growth policy) {
  const auto culling = decode_culling(request.culling());
  if (!culling) return culling.error();
  auto query = decode_common(request, policy);
  if (query) query->culling = *culling;
  return query;
}

Result<CastQuery> decode_query(const v1::QueryPointsRequest& request, Growth policy) {
  auto query = decode_common(request, policy);
  if (query) query->points = true;
  return query;
}

}  // namespace sightline::server::queries
