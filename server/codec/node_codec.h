// Decodes and encodes nodes.
#pragma once

#include "proto/result.h"
#include "scenegraph/model/node.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::codec {

/// Errors: kInvalidArgument, unless it has 12 numbers.
Result<scenegraph::model::Affine> decode_transform(const v1::Transform& transform);
/// Errors: kInvalidArgument.
Result<scenegraph::model::Mobility> decode_mobility(v1::Mobility mobility);
v1::Mobility encode_mobility(scenegraph::model::Mobility mobility);
/// Labels as they are, for check_labels().
scenegraph::model::Labels decode_labels(
    const google::protobuf::RepeatedPtrField<v1::Label>& labels);
void encode_labels(const scenegraph::model::Labels& labels,
                   google::protobuf::RepeatedPtrField<v1::Label>& out);
void encode_node(const scenegraph::model::Node& node, v1::Node& out);
/// Decodes a node without its mesh. Errors: kInvalidArgument.
Result<scenegraph::model::Node> decode_node(const v1::Node& node);

}  // namespace sightline::server::codec
