// Decodes and encodes scenes and nodes.
#include "server/updates/scene_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/scenes/names.h"

namespace sightline::server::updates {

using scenegraph::model::Affine;
using scenegraph::model::Mobility;

Result<scenes::SceneInfo> decode_scene(const v1::Scene& scene) {
  if (const Status good = scenes::check_scene_name(scene.name()); !good) return good.error();
  scenes::SceneInfo info{scene.name(), scenes::UpAxis::kUnspecified, scene.meters_per_unit()};
  if (!std::isfinite(info.meters_per_unit) || info.meters_per_unit < 0) {
    return exec::invalid_argument(fmt::format("meters_per_unit is {}, expected a positive "
                                              "number, or 0 for unknown",
                                              info.meters_per_unit),
                                  "BAD_UNIT");
  }
  switch (scene.up_axis()) {
    case v1::UP_AXIS_UNSPECIFIED:
      break;
    case v1::UP_AXIS_Y:
      info.up_axis = scenes::UpAxis::kY;
      break;
    case v1::UP_AXIS_Z:
      info.up_axis = scenes::UpAxis::kZ;
      break;
    default:
      return exec::invalid_argument(
          fmt::format("up axis {} is not known", static_cast<int>(scene.up_axis())),
          "UNKNOWN_UP_AXIS");
  }
  return info;
}

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

void encode_info(const scenes::SceneInfo& info, v1::Scene& scene) {
  scene.set_name(info.name);
  scene.set_up_axis(info.up_axis == scenes::UpAxis::kY   ? v1::UP_AXIS_Y
                    : info.up_axis == scenes::UpAxis::kZ ? v1::UP_AXIS_Z
                                                         : v1::UP_AXIS_UNSPECIFIED);
  scene.set_meters_per_unit(info.meters_per_unit);
}

void encode_scene(const scenes::SceneInfo& info, const scenes::RevisionToken& head,
                  const scenegraph::revision::SceneSummary& summary, v1::Scene& scene) {
  encode_info(info, scene);
  encode_revision(head, *scene.mutable_head());
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

void encode_node(const scenegraph::model::Node& node, v1::Node& out) {
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

Result<scenegraph::model::Node> decode_node(const v1::Node& node) {
  scenegraph::model::Node decoded;
  decoded.id = node.id();
  decoded.parent = node.parent();
  decoded.name = node.name();
  const auto transform = decode_transform(node.transform());
  if (!transform) return transform.error();
  decoded.parent_from_local = *transform;
  const auto mobility = decode_mobility(node.mobility());
  if (!mobility) return mobility.error();
  decoded.mobility = *mobility;
  decoded.mask = node.mask();
  return decoded;
}

void encode_stats(const scenes::RevisionToken& revision,
                  const scenegraph::revision::BuildSummary& summary,
                  v1::GetSceneStatsResponse& reply) {
  encode_revision(revision, *reply.mutable_revision());
  reply.set_instances_total(summary.instances_total);
  reply.set_instances_entered(summary.instances_entered);
  reply.set_trees_built(summary.trees_built);
  reply.set_cells_deferred(summary.cells_deferred);
  reply.set_cells_expanded(summary.cells_expanded);
  reply.set_triangles_built(summary.triangles_built);
  reply.set_triangles_total(summary.triangles_total);
  reply.set_bytes_geometry(summary.bytes_geometry);
  reply.set_bytes_trees(summary.bytes_trees);
  reply.set_bytes_lists(summary.bytes_lists);
  reply.set_bytes_wide_nodes(summary.bytes_wide_nodes);
  reply.set_static_instances(summary.static_instances);
  reply.set_dynamic_instances(summary.dynamic_instances);
}

}  // namespace sightline::server::updates
