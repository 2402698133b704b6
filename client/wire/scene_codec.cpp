// Field by field.
#include "client/wire/scene_codec.h"

#include <algorithm>

namespace sightline::client::wire {

v1::UpAxis encode(UpAxis axis) {
  switch (axis) {
    case UpAxis::kY:
      return v1::UP_AXIS_Y;
    case UpAxis::kZ:
      return v1::UP_AXIS_Z;
    case UpAxis::kUnknown:
      break;
  }
  return v1::UP_AXIS_UNSPECIFIED;
}

v1::Mobility encode(Mobility mobility) {
  switch (mobility) {
    case Mobility::kStatic:
      return v1::MOBILITY_STATIC;
    case Mobility::kRigid:
      return v1::MOBILITY_RIGID;
    case Mobility::kDeforming:
      return v1::MOBILITY_DEFORMING;
  }
  return v1::MOBILITY_UNSPECIFIED;
}

v1::Transform encode(const Transform& transform) {
  v1::Transform out;
  out.mutable_matrix()->Add(transform.begin(), transform.end());
  return out;
}

Mobility decode(v1::Mobility mobility) {
  if (mobility == v1::MOBILITY_RIGID) return Mobility::kRigid;
  if (mobility == v1::MOBILITY_DEFORMING) return Mobility::kDeforming;
  return Mobility::kStatic;
}

namespace {

UpAxis decode(v1::UpAxis axis) {
  if (axis == v1::UP_AXIS_Y) return UpAxis::kY;
  if (axis == v1::UP_AXIS_Z) return UpAxis::kZ;
  return UpAxis::kUnknown;
}

}  // namespace

SceneInfo decode(const v1::Scene& scene) {
  SceneInfo info;
  info.name = scene.name();
  info.revision = scene.head().revision();
  info.token = scene.head().token();
  info.up_axis = decode(scene.up_axis());
  info.meters_per_unit = scene.meters_per_unit();
  info.nodes = scene.nodes();
  info.instances = scene.instances();
  info.meshes = scene.meshes();
  info.triangles_unique = scene.triangles_unique();
  info.triangles_instanced = scene.triangles_instanced();
  info.triangles_nonfinite = scene.triangles_nonfinite();
  info.bytes_geometry = scene.bytes_geometry();
  if (scene.bounds_size() == 6) {
    std::copy(scene.bounds().begin(), scene.bounds().end(), info.bounds.emplace().begin());
  }
  return info;
}

SceneStats decode(const v1::GetSceneStatsResponse& stats) {
  SceneStats out;
  out.revision = stats.revision().revision();
  out.instances_total = stats.instances_total();
  out.instances_entered = stats.instances_entered();
  out.trees_built = stats.trees_built();
  out.cells_deferred = stats.cells_deferred();
  out.cells_expanded = stats.cells_expanded();
  out.triangles_built = stats.triangles_built();
  out.triangles_total = stats.triangles_total();
  out.bytes_geometry = stats.bytes_geometry();
  out.bytes_trees = stats.bytes_trees();
  out.static_instances = stats.static_instances();
  out.dynamic_instances = stats.dynamic_instances();
  return out;
}

NodeInfo decode(const v1::Node& node) {
  NodeInfo info;
  info.id = node.id();
  info.parent = node.parent();
  info.name = node.name();
  if (node.transform().matrix_size() == 12) {
    std::copy(node.transform().matrix().begin(), node.transform().matrix().end(),
              info.parent_from_local.begin());
  }
  info.mesh_digest = node.mesh_digest();
  info.mobility = decode(node.mobility());
  info.mask = node.mask();
  info.patched = node.patched();
  return info;
}

ServerInfo decode(const v1::GetServerInfoResponse& info) {
  ServerInfo out;
  out.version = info.version();
  out.features.assign(info.features().begin(), info.features().end());
  out.max_message_bytes = info.max_message_bytes();
  out.max_blob_chunk_bytes = info.max_blob_chunk_bytes();
  out.max_rays_per_request = info.max_rays_per_request();
  out.max_rays_queued = info.max_rays_queued();
  out.max_bytes_queued = info.max_bytes_queued();
  out.max_triangles_per_mesh = info.max_triangles_per_mesh();
  out.max_depth = info.max_depth();
  out.policy = info.policy();
  out.threads = info.threads();
  out.simd_target = info.simd_target();
  out.max_hits_per_ray = info.max_hits_per_ray();
  out.max_hits_per_reply = info.max_hits_per_reply();
  out.max_exclusions = info.max_exclusions();
  out.max_prefetches = info.max_prefetches();
  out.max_updates_per_batch = info.max_updates_per_batch();
  out.max_batch_bytes = info.max_batch_bytes();
  out.update_window = info.update_window();
  out.max_update_streams = info.max_update_streams();
  out.max_watches = info.max_watches();
  out.max_waiting_reads = info.max_waiting_reads();
  out.max_read_wait_ms = info.max_read_wait_ms();
  out.max_exact_revisions = info.max_exact_revisions();
  out.max_logged_revisions = info.max_logged_revisions();
  out.max_request_ids = info.max_request_ids();
  out.max_producers = info.max_producers();
  return out;
}

}  // namespace sightline::client::wire
