// What the server reports about itself, scenes and nodes.
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
  std::string token;  ///< the revision's, for Consistency::at_least
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: unknown
  /// In a list: the server has not read the scene from its disk yet, and all below is not known.
  bool unread = false;
  std::uint64_t nodes = 0;
  std::uint64_t instances = 0;  ///< nodes that have a mesh
  std::uint64_t meshes = 0;     ///< distinct by content, as are unique triangles
  std::uint64_t triangles_unique = 0;
  std::uint64_t triangles_instanced = 0;
  std::uint64_t triangles_nonfinite = 0;  ///< among the unique ones; never hit
  std::uint64_t bytes_geometry = 0;
  /// World coordinates: min x y z, max x y z. Not set for a scene without triangles.
  std::optional<std::array<double, 6>> bounds;
};

/// How much of a scene's trees is built.
struct SceneStats {
  std::uint64_t revision = 0;
  std::uint64_t instances_total = 0;
  std::uint64_t instances_entered = 0;
  std::uint64_t trees_built = 0;  ///< mesh trees with at least one finished leaf
  std::uint64_t cells_deferred = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t triangles_built = 0;  ///< distinct triangles in finished leaves
  std::uint64_t triangles_total = 0;  ///< triangles of distinct meshes
  std::uint64_t bytes_geometry = 0;
  std::uint64_t bytes_trees = 0;
  std::uint64_t bytes_lists = 0;  ///< part of bytes_trees: what is not built in the meshes' trees
  std::uint64_t bytes_wide_nodes = 0;  ///< part of bytes_trees: what is built in them
  std::uint64_t static_instances = 0;
  std::uint64_t dynamic_instances = 0;
};

struct NodeInfo {
  std::uint64_t id = 0;      ///< 0: there is no such node
  std::uint64_t parent = 0;  ///< 0: a root
  std::string name;
  Transform parent_from_local = kIdentity;
  std::string mesh_digest;  ///< empty: a group
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = 0;
  bool patched = false;  ///< vertices were changed since the mesh of that digest was put
  std::vector<Label> labels;
};

/// What a node has, in the mesh's frame.
struct NodeMesh {
  std::uint64_t revision = 0;
  std::vector<Vertex> vertices;
  std::vector<Face> faces;  ///< by primitive; all kNoVertex: no triangle
};

/// Bytes that a server holds, by what for.
struct HeldBytes {
  std::string kind;
  std::uint64_t bytes = 0;
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
  std::uint32_t max_hits_per_ray = 0;    ///< for QueryKind::kAll
  std::uint32_t max_hits_per_reply = 0;  ///< per message: rays times CastOptions::max_hits
  std::uint32_t max_exclusions = 0;
  std::uint32_t max_labels_per_node = 0;
  std::uint32_t max_label_key_bytes = 0;
  std::uint32_t max_label_value_bytes = 0;
  std::uint32_t max_label_bytes_per_node = 0;  ///< keys and values
  std::uint32_t max_label_matches = 0;  ///< of CastOptions::only_labels, and of exclude_labels
  std::uint32_t max_prefetches = 0;     ///< running at the same time
  std::uint32_t max_updates_per_batch = 0;
  std::uint64_t max_batch_bytes = 0;     ///< a batch of an UpdateStream
  std::uint32_t update_window = 0;       ///< batches of an UpdateStream that are not answered
  std::uint32_t max_update_streams = 0;  ///< open at the same time, like the next two
  std::uint32_t max_watches = 0;
  std::uint32_t max_waiting_reads = 0;     ///< reads that wait for a revision
  std::uint32_t max_read_wait_ms = 0;      ///< how long each may wait
  std::uint64_t max_exact_revisions = 0;   ///< those that can be read in addition to the newest
  std::uint64_t max_logged_revisions = 0;  ///< from which a watch can start
  std::uint32_t max_request_ids = 0;       ///< requests whose answers are kept, per scene
  std::uint32_t max_producers = 0;         ///< names per scene
  std::uint32_t max_scenes = 0;
  std::uint32_t max_connections = 0;
  std::uint64_t max_segment_bytes = 0;  ///< of shared memory; 0: the server offers this client none
  std::uint32_t max_segments = 0;       ///< open at the same time, like the next one
  std::uint32_t max_segments_per_principal = 0;
  std::uint64_t max_rays_per_shared_request = 0;  ///< by a segment
  std::uint64_t memory_budget_bytes = 0;          ///< for all that the server holds
  bool is_durable = false;                        ///< it keeps scenes on disk
  std::vector<HeldBytes> memory;                  ///< what it holds now
  std::vector<HeldBytes> tree_memory;             ///< the parts of its kind "trees"
  std::uint64_t tree_pieces_evicted = 0;          ///< subtrees and lists, to keep within the budget
  std::uint64_t tree_bytes_evicted = 0;
};

}  // namespace sightline::client
