// One name for another.
#include "client/wire/option_codec.h"

namespace sightline::client::wire {

v1::QueryKind encode(QueryKind kind) {
  switch (kind) {
    case QueryKind::kClosest:
      return v1::QUERY_KIND_CLOSEST;
    case QueryKind::kAny:
      return v1::QUERY_KIND_ANY;
    case QueryKind::kCount:
      return v1::QUERY_KIND_COUNT;
    case QueryKind::kAll:
      return v1::QUERY_KIND_ALL;
  }
  return v1::QUERY_KIND_UNSPECIFIED;
}

v1::Culling encode(Culling culling) {
  switch (culling) {
    case Culling::kNone:
      return v1::CULLING_NONE;
    case Culling::kBack:
      return v1::CULLING_BACK;
    case Culling::kFront:
      return v1::CULLING_FRONT;
  }
  return v1::CULLING_UNSPECIFIED;
}

v1::BuildMode encode(BuildMode build) {
  switch (build) {
    case BuildMode::kServerPolicy:
      return v1::BUILD_MODE_UNSPECIFIED;
    case BuildMode::kLazy:
      return v1::BUILD_MODE_LAZY;
    case BuildMode::kFull:
      return v1::BUILD_MODE_FULL;
    case BuildMode::kNone:
      return v1::BUILD_MODE_NONE;
    case BuildMode::kBuiltOnly:
      return v1::BUILD_MODE_BUILT_ONLY;
  }
  return v1::BUILD_MODE_UNSPECIFIED;
}

v1::SideRule encode(SideRule rule) {
  switch (rule) {
    case SideRule::kParity:
      return v1::SIDE_RULE_PARITY;
    case SideRule::kWinding:
      return v1::SIDE_RULE_WINDING;
    case SideRule::kNormal:
      return v1::SIDE_RULE_NORMAL;
  }
  return v1::SIDE_RULE_UNSPECIFIED;
}

void encode(const std::vector<LabelMatch>& matches,
            google::protobuf::RepeatedPtrField<v1::LabelMatch>& out) {
  for (const LabelMatch& match : matches) {
    v1::LabelMatch& encoded = *out.Add();
    encoded.set_key(match.key);
    if (match.value) encoded.set_value(*match.value);
  }
}

}  // namespace sightline::client::wire
