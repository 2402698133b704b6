// Decodes and encodes nodes.
#include "server/codec/node_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "server/exec/rpc_status.h"

namespace sightline::server::codec {

using scenegraph::model::Affine;
using scenegraph::model::Mobility;

Result<Affine> decode_transform(const v1::Transform& transform) {
  Affine affine;
  if (static_cast<std::size_t>(transform.matrix_size()) != affine.m.size()) {
    return exec::invalid_argument(
        fmt::format("a matrix has {} numbers, expected 12", transform.matrix_size()),
        "MATRIX_LENGTH");
  }
  std::copy(transform.matrix().begin(), transform.matrix().end(), affine.m.begin());
  return affine;
}

Result<Mobility> decode_mobility(v1::Mobility mobility) {
  switch (mobility) {
    case v1::MOBILITY_UNSPECIFIED:
    case v1::MOBILITY_STATIC:
      return Mobility::kStatic;
    case v1::MOBILITY_RIGID:
      return Mobility::kRigid;
    case v1::MOBILITY_DEFORMING:
      return Mobility::kDeforming;
    default:
      return exec::invalid_argument(
          fmt::format("mobility {} is not known", static_cast<int>(mobility)), "UNKNOWN_MOBILITY");
  }
}

v1::Mobility encode_mobility(scenegraph::model::Mobility mobility) {
  switch (mobility) {
    case scenegraph::model::Mobility::kRigid:
      return v1::MOBILITY_RIGID;
    case scenegraph::model::Mobility::kDeforming:
      return v1::MOBILITY_DEFORMING;
    case scenegraph::model::Mobility::kStatic:
      break;
  }
  return v1::MOBILITY_STATIC;
}

scenegraph::model::Labels decode_labels(
    const google::protobuf::RepeatedPtrField<v1::Label>& labels) {
  if (labels.empty()) return nullptr;
  std::vector<scenegraph::model::Label> decoded;
  decoded.reserve(static_cast<std::size_t>(labels.size()));
  for (const v1::Label& label : labels) decoded.push_back({label.key(), label.value()});
  return std::make_shared<const std::vector<scenegraph::model::Label>>(std::move(decoded));
}

void encode_labels(const scenegraph::model::Labels& labels,
                   google::protobuf::RepeatedPtrField<v1::Label>& out) {
  if (labels == nullptr) return;
  out.Reserve(static_cast<int>(labels->size()));
  for (const scenegraph::model::Label& label : *labels) {
    v1::Label& encoded = *out.Add();
    encoded.set_key(label.key);
    encoded.set_value(label.value);
  }
}

void encode_node(const scenegraph::model::Node& node, v1::Node& out) {
  out.set_id(node.id);
  out.set_parent(node.parent);
  out.set_name(node.name);
  encode_labels(node.labels, *out.mutable_labels());
  out.mutable_transform()->mutable_matrix()->Assign(node.parent_from_local.m.begin(),
                                                    node.parent_from_local.m.end());
  out.set_mesh_digest(node.mesh_digest);
  out.set_mobility(encode_mobility(node.mobility));
  out.set_mask(node.mask);
  out.set_patched(node.patched);
}

Result<scenegraph::model::Node> decode_node(const v1::Node& node) {
  scenegraph::model::Node decoded;
  decoded.id = node.id();
  decoded.parent = node.parent();
  decoded.name = node.name();
  decoded.labels = decode_labels(node.labels());
  const auto transform = decode_transform(node.transform());
  if (!transform) return transform.error();
  decoded.parent_from_local = *transform;
  const auto mobility = decode_mobility(node.mobility());
  if (!mobility) return mobility.error();
  decoded.mobility = *mobility;
  decoded.mask = node.mask();
  return decoded;
}

}  // namespace sightline::server::codec
