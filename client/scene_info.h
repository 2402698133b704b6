// What the server tells of itself, of scenes and of nodes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/types.h"

namespace sightline::client {

struct SceneInfo {
  std::string name;  ///< projects/{project}/scenes/{scene}
  std::uint64_t revision = 0;
  std::string token;  ///< Of the revision, for Consistency::at_least.
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: unknown.
  std::uint64_t nodes = 0;
  std::uint64_t instances = 0;  ///< Nodes that carry a mesh.
  std::uint64_t meshes = 0;     ///< Distinct by content, as are unique triangles.
  std::uint64_t triangles_unique = 0;
  std::uint64_t triangles_instanced = 0;
  std::uint64_t triangles_nonfinite = 0;  ///< Of the unique ones; never hit.
  std::uint64_t bytes_geometry = 0;
  /// World: min x y z, max x y z. Nothing for a scene without triangles.
  std::optional<std::array<double, 6>> bounds;
};

/// How much of a scene's trees is built.
struct SceneStats {
  std::uint64_t revision = 0;
  std::uint64_t instances_total = 0;
  std::uint64_t instances_entered = 0;
  std::uint64_t trees_built = 0;  ///< Mesh trees with at least one finished leaf.
  std::uint64_t cells_deferred = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t triangles_built = 0;  ///< Distinct triangles in finished leaves.
  std::uint64_t triangles_total = 0;  ///< Of distinct meshes.
  std::uint64_t bytes_geometry = 0;
  std::uint64_t bytes_trees = 0;
  std::uint64_t static_instances = 0;
  std::uint64_t dynamic_instances = 0;
};

struct NodeInfo {
  std::uint64_t id = 0;      ///< 0: there is no such node.
  std::uint64_t parent = 0;  ///< 0: a root.
  std::string name;
  Transform parent_from_local = kIdentity;
  std::string mesh_digest;  ///< Empty: a group.
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = 0;
  bool patched = false;  ///< Its vertices have been changed since the mesh of that digest was put.
};

struct ServerInfo {
  std::string version;
  std::vector<std::string> features;
  std::uint64_t max_message_bytes = 0;
  std::uint64_t max_blob_chunk_bytes = 0;
  std::uint64_t max_rays_per_request = 0;
  std::uint64_t max_rays_queued = 0;
  std::uint64_t max_bytes_queued = 0;
  std::uint64_t max_triangles_per_mesh = 0;
  std::uint32_t max_depth = 0;
  std::string policy;
  std::uint32_t threads = 0;
  std::string simd_target;
  std::uint32_t max_hits_per_ray = 0;    ///< Of QueryKind::kAll.
  std::uint32_t max_hits_per_reply = 0;  ///< Of one message: rays times CastOptions::max_hits.
  std::uint32_t max_exclusions = 0;
  std::uint32_t max_prefetches = 0;  ///< In work at a time.
  std::uint32_t max_updates_per_batch = 0;
  std::uint64_t max_batch_bytes = 0;     ///< Of a batch of an UpdateStream.
  std::uint32_t update_window = 0;       ///< Batches of an UpdateStream on their way.
  std::uint32_t max_update_streams = 0;  ///< Open at a time, as the next two.
  std::uint32_t max_watches = 0;
  std::uint32_t max_waiting_reads = 0;     ///< That wait for a revision.
  std::uint32_t max_read_wait_ms = 0;      ///< Of each.
  std::uint64_t max_exact_revisions = 0;   ///< That can be read beside the newest.
  std::uint64_t max_logged_revisions = 0;  ///< That a watch can begin before.
  std::uint32_t max_request_ids = 0;       ///< Whose answers are kept, of a scene.
  std::uint32_t max_producers = 0;         ///< Names in a scene.
};

}  // namespace sightline::client
