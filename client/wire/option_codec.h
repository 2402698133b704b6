// Options that are one of a few, to messages. Internal to the library.
#pragma once

#include <vector>

#include "client/cast_options.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

v1::QueryKind encode(QueryKind kind);
v1::BuildMode encode(BuildMode build);
v1::Culling encode(Culling culling);
v1::SideRule encode(SideRule rule);
void encode(const std::vector<LabelMatch>& matches,
            google::protobuf::RepeatedPtrField<v1::LabelMatch>& out);

}  // namespace sightline::client::wire
