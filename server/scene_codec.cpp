// Scenes, nodes and updates between the wire and the scene graph.
#include "server/scene_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <utility>

#include "server/names.h"

namespace sightline::server {
namespace {

using scenegraph::Affine;
using scenegraph::Mobility;

constexpr std::size_t kMatrixBytes = sizeof(Affine::m);
constexpr std::size_t kMissingNamed = 4;  // as many digests as fit an error message

Error invalid(std::string message, std::string reason) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

Result<Affine> decode_transform(const v1::Transform& transform) {
  Affine affine;
  if (static_cast<std::size_t>(transform.matrix_size()) != affine.m.size()) {
    return invalid(fmt::format("a matrix has {} numbers, expected 12", transform.matrix_size()),
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
      return invalid(fmt::format("mobility {} is not known", static_cast<int>(mobility)),
                     "UNKNOWN_MOBILITY");
  }
}

v1::Mobility encode_mobility(Mobility mobility) {
  switch (mobility) {
    case Mobility::kRigid:
      return v1::MOBILITY_RIGID;
    case Mobility::kDeforming:
      return v1::MOBILITY_DEFORMING;
    case Mobility::kStatic:
      break;
  }
  return v1::MOBILITY_STATIC;
}

/// Decodes one batch, and gathers the digests that no mesh was uploaded for.
class UpdateDecoder {
 public:
  explicit UpdateDecoder(const BlobStore& blobs) : blobs_(blobs) {}

  Result<scenegraph::Update> decode(const v1::Update& update) {
    switch (update.update_case()) {
      case v1::Update::kPutNode:
        return decode_put(update.put_node());
      case v1::Update::kSetTransforms:
        return decode_set(update.set_transforms());
      case v1::Update::kDeleteNode:
        return scenegraph::Update(
            scenegraph::DeleteNode{update.delete_node().node(), update.delete_node().subtree()});
      case v1::Update::kPatchVertices:
        return decode_patch(update.patch_vertices());
      case v1::Update::UPDATE_NOT_SET:
        break;
    }
    return invalid("it says nothing that this server knows", "EMPTY_UPDATE");
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
  Result<scenegraph::Update> decode_put(const v1::PutNode& put) {
    scenegraph::PutNode node;
    node.node = put.node();
    node.parent = put.parent();
    node.name = put.name();
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
      const auto digest = BlobDigest::parse(put.mesh_digest());
      if (!digest) return digest.error();
      node.mesh = blobs_.find(*digest);
      node.mesh_digest = put.mesh_digest();
      if (node.mesh == nullptr) missing_.insert(put.mesh_digest());
    }
    return scenegraph::Update(std::move(node));
  }

  static Result<scenegraph::Update> decode_set(const v1::SetTransforms& set) {
    const auto count = static_cast<std::size_t>(set.nodes_size());
    if (set.matrices().size() != count * kMatrixBytes) {
      return invalid(fmt::format("column matrices has {} bytes, expected {} ({} nodes of {} bytes)",
                                 set.matrices().size(), count * kMatrixBytes, count, kMatrixBytes),
                     "COLUMN_LENGTH");
    }
    scenegraph::SetTransforms transforms;
    transforms.nodes.assign(set.nodes().begin(), set.nodes().end());
    transforms.parent_from_local.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(transforms.parent_from_local[i].m.data(),
                  set.matrices().data() + i * kMatrixBytes, kMatrixBytes);
    }
    return scenegraph::Update(std::move(transforms));
  }

  static Result<scenegraph::Update> decode_patch(const v1::PatchVertices& patch) {
    const std::size_t bytes = patch.positions().size();
    if (bytes % sizeof(accel::Vec3f) != 0) {
      return invalid(fmt::format("column positions has {} bytes, expected a multiple of {}", bytes,
                                 sizeof(accel::Vec3f)),
                     "COLUMN_LENGTH");
    }
    scenegraph::PatchVertices vertices;
    vertices.nodes.assign(patch.nodes().begin(), patch.nodes().end());
    vertices.first = patch.first();
    vertices.positions.resize(bytes / sizeof(accel::Vec3f));
    std::memcpy(vertices.positions.data(), patch.positions().data(), bytes);
    return scenegraph::Update(std::move(vertices));
  }

  const BlobStore& blobs_;
  std::set<std::string> missing_;
};

}  // namespace

Result<SceneInfo> decode_scene(const v1::Scene& scene) {
  if (const Status good = check_scene_name(scene.name()); !good) return good.error();
  SceneInfo info{scene.name(), UpAxis::kUnspecified, scene.meters_per_unit()};
  if (!std::isfinite(info.meters_per_unit) || info.meters_per_unit < 0) {
    return invalid(
        fmt::format("meters_per_unit is {}, expected a positive number, or 0 for unknown",
                    info.meters_per_unit),
        "BAD_UNIT");
  }
  switch (scene.up_axis()) {
    case v1::UP_AXIS_UNSPECIFIED:
      break;
    case v1::UP_AXIS_Y:
      info.up_axis = UpAxis::kY;
      break;
    case v1::UP_AXIS_Z:
      info.up_axis = UpAxis::kZ;
      break;
    default:
      return invalid(fmt::format("up axis {} is not known", static_cast<int>(scene.up_axis())),
                     "UNKNOWN_UP_AXIS");
  }
  return info;
}

Result<std::vector<scenegraph::Update>> decode_updates(const v1::ApplyUpdatesRequest& request,
                                                       const BlobStore& blobs) {
  if (request.updates_size() > kMaxUpdatesPerBatch) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the batch has {} updates, the limit is {}", request.updates_size(),
                             kMaxUpdatesPerBatch),
                 "TOO_MANY_UPDATES"};
  }
  UpdateDecoder decoder(blobs);
  std::vector<scenegraph::Update> updates;
  updates.reserve(static_cast<std::size_t>(request.updates_size()));
  for (const v1::Update& update : request.updates()) {
    auto decoded = decoder.decode(update);
    if (!decoded) {
      Error error = decoded.error();
      error.message = fmt::format("update {}: {}", updates.size(), error.message);
      return error;
    }
    updates.push_back(std::move(*decoded));
  }
  if (const Status found = decoder.check_missing(); !found) return found.error();
  return updates;
}

void encode_scene(const SceneInfo& info, const scenegraph::SceneSummary& summary,
                  v1::Scene& scene) {
  scene.set_name(info.name);
  scene.mutable_head()->set_revision(summary.revision);
  scene.set_up_axis(info.up_axis == UpAxis::kY   ? v1::UP_AXIS_Y
                    : info.up_axis == UpAxis::kZ ? v1::UP_AXIS_Z
                                                 : v1::UP_AXIS_UNSPECIFIED);
  scene.set_meters_per_unit(info.meters_per_unit);
  scene.set_nodes(summary.nodes);
  scene.set_instances(summary.instances);
  scene.set_meshes(summary.meshes);
  scene.set_triangles_unique(summary.triangles_unique);
  scene.set_triangles_instanced(summary.triangles_instanced);
  scene.set_triangles_nonfinite(summary.triangles_nonfinite);
  scene.set_bytes_geometry(summary.bytes_geometry);
  if (!std::isnan(summary.bounds[0]))
    scene.mutable_bounds()->Assign(summary.bounds.begin(), summary.bounds.end());
}

void encode_node(const scenegraph::Node& node, v1::Node& out) {
  out.set_id(node.id);
  out.set_parent(node.parent);
  out.set_name(node.name);
  out.mutable_transform()->mutable_matrix()->Assign(node.parent_from_local.m.begin(),
                                                    node.parent_from_local.m.end());
  out.set_mesh_digest(node.mesh_digest);
  out.set_mobility(encode_mobility(node.mobility));
  out.set_mask(node.mask);
  out.set_patched(node.patched);
}

void encode_stats(std::uint64_t revision, const scenegraph::BuildSummary& summary,
                  v1::GetSceneStatsResponse& reply) {
  reply.mutable_revision()->set_revision(revision);
  reply.set_instances_total(summary.instances_total);
  reply.set_instances_entered(summary.instances_entered);
  reply.set_trees_built(summary.trees_built);
  reply.set_cells_deferred(summary.cells_deferred);
  reply.set_cells_expanded(summary.cells_expanded);
  reply.set_triangles_built(summary.triangles_built);
  reply.set_triangles_total(summary.triangles_total);
  reply.set_bytes_geometry(summary.bytes_geometry);
  reply.set_bytes_trees(summary.bytes_trees);
  reply.set_static_instances(summary.static_instances);
  reply.set_dynamic_instances(summary.dynamic_instances);
}

}  // namespace sightline::server
