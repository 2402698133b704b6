// Decodes and encodes updates.
#include "server/codec/update_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <utility>

#include "server/codec/node_codec.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::codec {
namespace {

using scenegraph::model::Affine;

constexpr std::size_t kMatrixBytes = sizeof(Affine::m);
constexpr std::size_t kMaxNodeBytes = 10;  // a node's number on the wire
constexpr std::size_t kMissingNamed = 4;   // digests in an error message

/// Decodes one batch, and gathers the digests that no mesh was uploaded for.
class UpdateDecoder {
 public:
  explicit UpdateDecoder(blobs::BlobStore& blobs) : blobs_(blobs) {}

  Result<scenegraph::model::Update> decode(const v1::Update& update) {
    switch (update.update_case()) {
      case v1::Update::kPutNode:
        return decode(update.put_node());
      case v1::Update::kSetTransforms:
        return decode_set(update.set_transforms());
      case v1::Update::kDeleteNode:
        return scenegraph::model::Update(scenegraph::model::DeleteNode{
            update.delete_node().node(), update.delete_node().subtree()});
      case v1::Update::kPatchVertices:
        return decode_patch(update.patch_vertices());
      case v1::Update::UPDATE_NOT_SET:
        break;
    }
    return exec::invalid_argument("it says nothing that this server knows", "EMPTY_UPDATE");
  }

  Result<scenegraph::model::Update> decode(const v1::PutNode& put) {
    scenegraph::model::PutNode node;
    node.node = put.node();
    node.parent = put.parent();
    node.name = put.name();
    node.labels = decode_labels(put.labels());
    if (put.has_transform()) {
      const auto transform = decode_transform(put.transform());
      if (!transform) return transform.error();
      node.parent_from_local = *transform;
    }
    const auto mobility = decode_mobility(put.mobility());
    if (!mobility) return mobility.error();
    node.mobility = *mobility;
    if (put.has_mask()) node.mask = put.mask();
    if (!put.mesh_digest().empty()) {
      const auto digest = blobs::BlobDigest::parse(put.mesh_digest());
      if (!digest) return digest.error();
      auto mesh = blobs_.use(*digest);
      if (!mesh && mesh.error().code != Code::kNotFound) return mesh.error();
      if (!mesh) missing_.insert(put.mesh_digest());
      if (mesh) node.mesh = std::move(*mesh);
      node.mesh_digest = put.mesh_digest();
    }
    return scenegraph::model::Update(std::move(node));
  }

  Status check_missing() const {
    if (missing_.empty()) return {};
    std::string list;
    std::size_t named = 0;
    for (auto it = missing_.begin(); it != missing_.end() && named < kMissingNamed; ++it, ++named)
      list += " " + *it;
    if (missing_.size() > named) list += fmt::format(" and {} more", missing_.size() - named);
    return Error{Code::kFailedPrecondition,
                 fmt::format("{} meshes were not uploaded or are gone, upload them first:{}",
                             missing_.size(), list),
                 "MESHES_MISSING"};
  }

 private:
  static Result<scenegraph::model::Update> decode_set(const v1::SetTransforms& set) {
    const auto count = static_cast<std::size_t>(set.nodes_size());
    if (set.matrices().size() != count * kMatrixBytes) {
      return exec::invalid_argument(
          fmt::format("column matrices has {} bytes, expected {} "
                      "({} nodes of {} bytes)",
                      set.matrices().size(), count * kMatrixBytes, count, kMatrixBytes),
          "COLUMN_LENGTH");
    }
    scenegraph::model::SetTransforms transforms;
    transforms.nodes.assign(set.nodes().begin(), set.nodes().end());
    transforms.parent_from_local.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(transforms.parent_from_local[i].m.data(),
                  set.matrices().data() + i * kMatrixBytes, kMatrixBytes);
    }
    return scenegraph::model::Update(std::move(transforms));
  }

  static Result<scenegraph::model::Update> decode_patch(const v1::PatchVertices& patch) {
    const std::size_t bytes = patch.positions().size();
    if (bytes % sizeof(accel::geometry::Vec3f) != 0) {
      return exec::invalid_argument(
          fmt::format("column positions has {} bytes, expected a multiple of {}", bytes,
                      sizeof(accel::geometry::Vec3f)),
          "COLUMN_LENGTH");
    }
    if (patch.nodes_size() > kMaxNodesPerPatch) {
      return exec::invalid_argument(fmt::format("a patch of {} nodes, the limit is {}",
                                                patch.nodes_size(), kMaxNodesPerPatch),
                                    "TOO_MANY_NODES");
    }
    scenegraph::model::PatchVertices vertices;
    vertices.nodes.assign(patch.nodes().begin(), patch.nodes().end());
    vertices.first = patch.first();
    vertices.positions.resize(bytes / sizeof(accel::geometry::Vec3f));
    if (bytes > 0) std::memcpy(vertices.positions.data(), patch.positions().data(), bytes);
    return scenegraph::model::Update(std::move(vertices));
  }

  blobs::BlobStore& blobs_;
  std::set<std::string> missing_;
};

/// Encodes each kind of update; see encode_update().
struct Encoder {
  std::size_t first;
  std::size_t bytes;
  v1::Update& out;

  std::size_t operator()(const scenegraph::model::PutNode& put) const {
    v1::PutNode& node = *out.mutable_put_node();
    node.set_node(put.node);
    node.set_parent(put.parent);
    node.set_name(put.name);
    encode_labels(put.labels, *node.mutable_labels());
    node.mutable_transform()->mutable_matrix()->Assign(put.parent_from_local.m.begin(),
                                                       put.parent_from_local.m.end());
    node.set_mesh_digest(put.mesh_digest);
    node.set_mobility(encode_mobility(put.mobility));
    node.set_mask(put.mask);
    return 0;
  }

  std::size_t operator()(const scenegraph::model::SetTransforms& set) const {
    const std::size_t end = end_of_rows(set.nodes.size(), bytes, kMatrixBytes + kMaxNodeBytes);
    v1::SetTransforms& rows = *out.mutable_set_transforms();
    const auto at = [](const auto& column, std::size_t row) {
      return column.begin() + static_cast<std::ptrdiff_t>(row);
    };
    rows.mutable_nodes()->Assign(at(set.nodes, first), at(set.nodes, end));
    std::string& matrices = *rows.mutable_matrices();
    matrices.reserve((end - first) * kMatrixBytes);
    for (std::size_t row = first; row < end; ++row) {
      matrices.append(reinterpret_cast<const char*>(set.parent_from_local[row].m.data()),
                      kMatrixBytes);
    }
    return end == set.nodes.size() ? 0 : end;
  }

  std::size_t operator()(const scenegraph::model::DeleteNode& removal) const {
    out.mutable_delete_node()->set_node(removal.node);
    out.mutable_delete_node()->set_subtree(removal.subtree);
    return 0;
  }

  std::size_t operator()(const scenegraph::model::PatchVertices& patch) const {
    const std::size_t nodes = patch.nodes.size() * kMaxNodeBytes;
    const std::size_t end = end_of_rows(patch.positions.size(), bytes - std::min(bytes, nodes),
                                        sizeof(accel::geometry::Vec3f));
    v1::PatchVertices& rows = *out.mutable_patch_vertices();
    rows.mutable_nodes()->Assign(patch.nodes.begin(), patch.nodes.end());
    rows.set_first(patch.first + static_cast<std::uint32_t>(first));
    rows.set_positions(patch.positions.data() + first,
                       (end - first) * sizeof(accel::geometry::Vec3f));
    return end == patch.positions.size() ? 0 : end;
  }

 private:
  std::size_t end_of_rows(std::size_t rows, std::size_t budget, std::size_t bytes_per_row) const {
    return std::min(rows, first + std::max<std::size_t>(1, budget / bytes_per_row));
  }
};

template <class Message>
Result<std::vector<scenegraph::model::Update>> decode_all(
    const google::protobuf::RepeatedPtrField<Message>& messages, blobs::BlobStore& blobs,
    std::size_t first) {
  UpdateDecoder decoder(blobs);
  std::vector<scenegraph::model::Update> decoded;
  decoded.reserve(static_cast<std::size_t>(messages.size()));
  for (const Message& message : messages) {
    auto one = decoder.decode(message);
    if (!one) {
      Error error = one.error();
      error.message = fmt::format("update {}: {}", first + decoded.size(), error.message);
      return error;
    }
    decoded.push_back(std::move(*one));
  }
  if (const Status found = decoder.check_missing(); !found) return found.error();
  return decoded;
}

}  // namespace

Status check_update_count(std::size_t count) {
  if (count <= static_cast<std::size_t>(kMaxUpdatesPerBatch)) return {};
  return Error{Code::kResourceExhausted,
               fmt::format("the batch has {} updates, the limit is {}", count, kMaxUpdatesPerBatch),
               "TOO_MANY_UPDATES"};
}

Result<std::vector<scenegraph::model::Update>> decode_updates(
    const google::protobuf::RepeatedPtrField<v1::Update>& updates, blobs::BlobStore& blobs,
    std::size_t first) {
  const Status fits = check_update_count(first + static_cast<std::size_t>(updates.size()));
  if (!fits) return fits.error();
  return decode_all(updates, blobs, first);
}

Result<std::vector<scenegraph::model::Update>> decode_nodes(
    const google::protobuf::RepeatedPtrField<v1::PutNode>& nodes, blobs::BlobStore& blobs,
    std::size_t first) {
  const Status fits = check_update_count(static_cast<std::size_t>(nodes.size()));
  if (!fits) return fits.error();
  return decode_all(nodes, blobs, first);
}

Result<std::vector<scenegraph::model::Update>> decode_kept_updates(
    const google::protobuf::RepeatedPtrField<v1::Update>& updates, blobs::BlobStore& blobs) {
  return decode_all(updates, blobs, 0);
}

std::size_t encode_update(const scenegraph::model::Update& update, std::size_t first,
                          std::size_t bytes, v1::Update& out) {
  return std::visit(Encoder{first, bytes, out}, update);
}

}  // namespace sightline::server::codec
