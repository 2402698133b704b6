// Decodes and encodes scenes.
#include "server/updates/scene_codec.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "server/exec/rpc_status.h"
#include "server/scenes/names.h"

namespace sightline::server::updates {

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
