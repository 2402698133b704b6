// The query of a cast: checks each value, and that the kind has it.
#include "server/queries/cast_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "scenegraph/query/shard_cut.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

using accel::geometry::Culling;
using scenegraph::Growth;
using scenegraph::QueryKind;
using scenegraph::SideRule;
using scenegraph::query::LabelMatch;

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

constexpr std::array kSideFields{v1::HIT_FIELD_SIGNED, v1::HIT_FIELD_INSIDE, v1::HIT_FIELD_VOTES,
                                 v1::HIT_FIELD_CROSSINGS};

/// The fields of a kind for points: closest faces have sides, too.
const FieldsOfKind& fields_of_points(QueryKind kind) {
  static const FieldsOfKind kClosest = [] {
    FieldsOfKind fields = fields_of(QueryKind::kClosest);
    fields.optional.insert(fields.optional.end(), kSideFields.begin(), kSideFields.end());
    return fields;
  }();
  return kind == QueryKind::kClosest ? kClosest : fields_of(kind);
}

using FieldsOf = const FieldsOfKind& (*)(QueryKind);

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

/// Checks that the columns of a segment are asked for in this way alone, and that their bytes
/// follow from the number of rays.
template <class Request>
Status check_answer(const Request& request, QueryKind kind) {
  if (request.fields_size() > 0) {
    return exec::invalid_argument(
        fmt::format(
            "`answer` has {} columns and `fields` has {}: with `answer` there are no others",
            request.answer_size(), request.fields_size()),
        "FIELDS_AND_ANSWER");
  }
  if (kind == QueryKind::kAll) {
    return exec::invalid_argument(
        "QUERY_KIND_ALL has no `answer`: how many hits there will be is not known before",
        "ANSWER_NOT_OF_KIND");
  }
  for (const v1::SharedColumn& column : request.answer()) {
    if (column.field() == v1::HIT_FIELD_CROSSINGS)
      return exec::invalid_argument("HIT_FIELD_CROSSINGS is not written to segments",
                                    "FIELD_NOT_IN_SEGMENT");
  }
  return {};
}

/// The fields that a request names, in its reply or in a segment.
template <class Request>
Result<std::vector<v1::HitField>> named_fields(const Request& request,
                                               const FieldsOfKind& of_kind) {
  std::vector<v1::HitField> named;
  const auto add = [&](v1::HitField field) {
    Status good = check_field(field, of_kind, request.kind(), named);
    if (good) named.push_back(field);
    return good;
  };
  for (const int number : request.fields()) {
    if (const Status good = add(static_cast<v1::HitField>(number)); !good) return good.error();
  }
  for (const v1::SharedColumn& column : request.answer()) {
    if (const Status good = add(column.field()); !good) return good.error();
  }
  return named;
}

template <class Request>
Status decode_fields(const Request& request, const FieldsOfKind& of_kind, CastQuery& query) {
  query.in_segment = request.answer_size() > 0;
  if (query.in_segment) {
    if (Status good = check_answer(request, query.kind); !good) return good;
  }
  auto named = named_fields(request, of_kind);
  if (!named) return named.error();
  const std::vector<v1::HitField>& asked = *named;
  for (const v1::HitField field : of_kind.always) {
    const bool in_bits = field == v1::HIT_FIELD_HIT && contains(asked, v1::HIT_FIELD_HIT_BITS);
    if (!query.in_segment && !in_bits && !contains(asked, field)) query.fields.push_back(field);
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

Result<std::vector<LabelMatch>> decode_matches(
    const google::protobuf::RepeatedPtrField<v1::LabelMatch>& matches, const char* list) {
  if (matches.size() > kMaxLabelMatches) {
    return exec::invalid_argument(
        fmt::format("{} has {} labels, the limit is {}", list, matches.size(), kMaxLabelMatches),
        "TOO_MANY_LABELS");
  }
  std::vector<LabelMatch> decoded;
  decoded.reserve(static_cast<std::size_t>(matches.size()));
  for (const v1::LabelMatch& match : matches) {
    if (const Status good = scenegraph::model::check_label(match.key(), match.value()); !good)
      return exec::invalid_argument(fmt::format("{}: {}", list, good.error().message),
                                    good.error().reason);
    decoded.push_back(
        {match.key(), match.has_value() ? std::optional(match.value()) : std::nullopt});
  }
  return decoded;
}

template <class Request>
Status decode_labels(const Request& request, CastQuery& query) {
  auto only = decode_matches(request.only_labels(), "only_labels");
  if (!only) return only.error();
  auto excluded = decode_matches(request.exclude_labels(), "exclude_labels");
  if (!excluded) return excluded.error();
  query.labels = {*std::move(only), *std::move(excluded)};
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
Result<CastQuery> decode_common(const Request& request, Growth policy, FieldsOf fields_of_kind) {
  const auto kind = decode_kind(request.kind());
  if (!kind) return kind.error();
  const auto growth = decode_growth(request.build(), policy);
  if (!growth) return growth.error();
  CastQuery query{.kind = *kind, .growth = *growth};
  if (const Status good = decode_fields(request, fields_of_kind(*kind), query); !good)
    return good.error();
  if (const Status good = decode_max_hits(request, query); !good) return good.error();
  if (const Status good = decode_nodes(request, query); !good) return good.error();
  if (const Status good = decode_labels(request, query); !good) return good.error();
  if (const Status good = decode_shard(request, query); !good) return good.error();
  return query;
}

bool is_of_sides(v1::HitField field) { return contains(kSideFields, field); }

/// Checks fields that only some questions of sides have.
Status check_side_fields(const CastQuery& query, SideRule rule) {
  const bool crossings = contains(query.fields, v1::HIT_FIELD_CROSSINGS);
  if (rule == SideRule::kNormal && (crossings || contains(query.fields, v1::HIT_FIELD_VOTES)))
    return exec::invalid_argument(
        "SIDE_RULE_NORMAL casts no rays, so there is no HIT_FIELD_VOTES or HIT_FIELD_CROSSINGS",
        "FIELD_NOT_OF_RULE");
  if (!crossings || query.shard) return {};
  return exec::invalid_argument("HIT_FIELD_CROSSINGS is of shards, and the request names none",
                                "NO_SHARD_NAMED");
}

Result<SideRule> decode_side_rule(v1::SideRule rule) {
  switch (rule) {
    case v1::SIDE_RULE_UNSPECIFIED:
    case v1::SIDE_RULE_PARITY:
      return SideRule::kParity;
    case v1::SIDE_RULE_WINDING:
      return SideRule::kWinding;
    case v1::SIDE_RULE_NORMAL:
      return SideRule::kNormal;
    default:
      return exec::invalid_argument(
          fmt::format("side rule {} is not known", static_cast<int>(rule)), "UNKNOWN_SIDE_RULE");
  }
}

Status decode_sides(const v1::QueryPointsRequest& request, CastQuery& query) {
  const auto rule = decode_side_rule(request.side_rule());
  if (!rule) return rule.error();
  if (std::none_of(query.fields.begin(), query.fields.end(), is_of_sides)) {
    if (request.side_rule() == v1::SIDE_RULE_UNSPECIFIED && request.side_rays() == 0) return {};
    return exec::invalid_argument(
        fmt::format("side_rule is {} and side_rays is {}, but neither SIGNED, INSIDE nor VOTES is "
                    "asked for",
                    v1::SideRule_Name(request.side_rule()), request.side_rays()),
        "SIDE_NOT_ASKED");
  }
  const scenegraph::SideQuestion question{*rule, std::max(request.side_rays(), 1u)};
  const std::uint32_t most = *rule == SideRule::kNormal ? 1 : scenegraph::kMaxSideRays;
  if (question.rays % 2 == 0 || question.rays > most) {
    return exec::invalid_argument(
        fmt::format("side_rays is {}: the number is odd, and for this rule at most {}",
                    question.rays, most),
        "SIDE_RAYS");
  }
  if (Status good = check_side_fields(query, *rule); !good) return good;
  query.sides = question;
  query.crossings = contains(query.fields, v1::HIT_FIELD_CROSSINGS);
  query.sides_alone = !contains(query.fields, v1::HIT_FIELD_SIGNED) &&
                      std::all_of(query.fields.begin(), query.fields.end(), is_of_sides);
  return {};
}

}  // namespace

Result<CastQuery> decode_query(const v1::CastRaysRequest& request, Growth policy) {
  const auto culling = decode_culling(request.culling());
  if (!culling) return culling.error();
  auto query = decode_common(request, policy, fields_of);
  if (query) query->culling = *culling;
  return query;
}

Result<CastQuery> decode_query(const v1::QueryPointsRequest& request, Growth policy) {
  auto query = decode_common(request, policy, fields_of_points);
  if (!query) return query;
  query->points = true;
  if (const Status good = decode_sides(request, *query); !good) return good.error();
  return query;
}

}  // namespace sightline::server::queries
