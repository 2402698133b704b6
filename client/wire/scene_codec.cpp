// Converts field by field. Arrays are sent as their bytes.
#include "client/wire/scene_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <variant>

namespace sightline::client::wire {
namespace {

constexpr std::size_t kTransformsPerUpdate = 4096;  // 96 bytes each, and a reference to the node
constexpr std::size_t kVerticesPerUpdate = 65536;   // 12 bytes each

static_assert(sizeof(Transform) == 96 && sizeof(Vertex) == 12, "columns are the arrays' bytes");

void encode_labels(const std::vector<Label>& labels,
                   google::protobuf::RepeatedPtrField<v1::Label>& out) {
  for (const Label& label : labels) {
    v1::Label& encoded = *out.Add();
    encoded.set_key(label.key);
    encoded.set_value(label.value);
  }
}

std::vector<Label> decode_labels(const google::protobuf::RepeatedPtrField<v1::Label>& labels) {
  std::vector<Label> decoded;
  decoded.reserve(static_cast<std::size_t>(labels.size()));
  for (const v1::Label& label : labels) decoded.push_back({label.key(), label.value()});
  return decoded;
}

struct Encoder {
  const NodeAliases& aliases;
  v1::Update& out;

  void operator()(const PutNode& put) const {
    v1::PutNode& node = *out.mutable_put_node();
    node.set_node(aliases.resolve(put.node));
    node.set_parent(aliases.resolve(put.parent));
    node.set_name(put.name);
    if (put.parent_from_local != kIdentity)
      *node.mutable_transform() = encode(put.parent_from_local);
    node.set_mesh_digest(put.mesh_digest);
    node.set_mobility(encode(put.mobility));
    node.set_mask(put.mask);
    encode_labels(put.labels, *node.mutable_labels());
  }
  void operator()(const SetTransforms& set) const {
    v1::SetTransforms& transforms = *out.mutable_set_transforms();
    for (const NodeRef node : set.nodes) transforms.add_nodes(aliases.resolve(node));
    transforms.set_matrices(set.parent_from_local.data(),
                            set.parent_from_local.size() * sizeof(Transform));
  }
  void operator()(const DeleteNode& deleted) const {
    out.mutable_delete_node()->set_node(aliases.resolve(deleted.node));
    out.mutable_delete_node()->set_subtree(deleted.subtree);
  }
  void operator()(const PatchVertices& patch) const {
    v1::PatchVertices& vertices = *out.mutable_patch_vertices();
    for (const NodeRef node : patch.nodes) vertices.add_nodes(aliases.resolve(node));
    vertices.set_first(patch.first);
    vertices.set_positions(patch.positions.data(), patch.positions.size() * sizeof(Vertex));
  }
};

// Returns false if the bytes are not a whole number of rows.
template <class Row>
bool copy_rows(const std::string& bytes, std::vector<Row>& rows) {
  if (bytes.size() % sizeof(Row) != 0) return false;
  rows.resize(bytes.size() / sizeof(Row));
  if (!bytes.empty()) std::memcpy(rows.data(), bytes.data(), bytes.size());
  return true;
}

PutNode decode(const v1::PutNode& put) {
  PutNode out;
  out.node = put.node();
  out.parent = put.parent();
  out.name = put.name();
  if (put.transform().matrix_size() == 12) {
    std::copy(put.transform().matrix().begin(), put.transform().matrix().end(),
              out.parent_from_local.begin());
  }
  out.mesh_digest = put.mesh_digest();
  out.mobility = client::wire::decode(put.mobility());
  if (put.has_mask()) out.mask = put.mask();
  out.labels = decode_labels(put.labels());
  return out;
}

// At most n rows of `list`, beginning with row `first`.
template <class T>
std::vector<T> part_of(const std::vector<T>& list, std::size_t first, std::size_t n) {
  const auto from = list.begin() + static_cast<std::ptrdiff_t>(first);
  return {from, from + static_cast<std::ptrdiff_t>(std::min(n, list.size() - first))};
}

}  // namespace

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
  info.unread = scene.unread();
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
  out.bytes_lists = stats.bytes_lists();
  out.bytes_wide_nodes = stats.bytes_wide_nodes();
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
  info.labels = decode_labels(node.labels());
  return info;
}

ServerInfo decode(const v1::GetServerInfoResponse& info) {
  const auto held = [](const auto& from) {
    std::vector<HeldBytes> to;
    for (const v1::HeldBytes& one : from) to.push_back({one.kind(), one.bytes()});
    return to;
  };
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
  out.max_labels_per_node = info.max_labels_per_node();
  out.max_label_key_bytes = info.max_label_key_bytes();
  out.max_label_value_bytes = info.max_label_value_bytes();
  out.max_label_bytes_per_node = info.max_label_bytes_per_node();
  out.max_label_matches = info.max_label_matches();
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
  out.max_scenes = info.max_scenes();
  out.max_connections = info.max_connections();
  out.max_segment_bytes = info.max_segment_bytes();
  out.max_segments = info.max_segments();
  out.max_segments_per_principal = info.max_segments_per_principal();
  out.max_rays_per_shared_request = info.max_rays_per_shared_request();
  out.memory_budget_bytes = info.memory_budget_bytes();
  out.memory = held(info.memory());
  out.tree_memory = held(info.tree_memory());
  out.tree_pieces_evicted = info.tree_pieces_evicted();
  out.tree_bytes_evicted = info.tree_bytes_evicted();
  out.is_durable =
      std::find(out.features.begin(), out.features.end(), "durable") != out.features.end();
  return out;
}

v1::Update encode(const Update& update, const NodeAliases& aliases) {
  v1::Update out;
  std::visit(Encoder{aliases, out}, update);
  return out;
}

Result<Update> decode(const v1::Update& update) {
  if (update.has_put_node()) return Update(decode(update.put_node()));
  if (update.has_delete_node())
    return Update(DeleteNode{update.delete_node().node(), update.delete_node().subtree()});
  if (update.has_set_transforms()) {
    const v1::SetTransforms& set = update.set_transforms();
    SetTransforms out{{set.nodes().begin(), set.nodes().end()}, {}};
    if (copy_rows(set.matrices(), out.parent_from_local)) return Update(std::move(out));
  }
  if (update.has_patch_vertices()) {
    const v1::PatchVertices& patch = update.patch_vertices();
    PatchVertices out{{patch.nodes().begin(), patch.nodes().end()}, patch.first(), {}};
    if (copy_rows(patch.positions(), out.positions)) return Update(std::move(out));
  }
  return Error{Code::kInternal, "the server tells of an update that cannot be read", {}};
}

v1::Consistency encode(const Consistency& consistency) {
  v1::Consistency out;
  if (consistency.exact_revision) {
    out.set_exact_revision(*consistency.exact_revision);
  } else if (!consistency.at_least.empty()) {
    out.set_at_least(consistency.at_least);
  }
  return out;
}

Status check(std::span<const Update> updates) {
  for (std::size_t i = 0; i < updates.size(); ++i) {
    const auto* set = std::get_if<SetTransforms>(&updates[i]);
    if (set == nullptr || set->nodes.size() == set->parent_from_local.size()) continue;
    return Error{Code::kInvalidArgument,
                 fmt::format("update {}: {} nodes but {} transforms", i, set->nodes.size(),
                             set->parent_from_local.size()),
                 {}};
  }
  return {};
}

Status each_piece(const Update& update, const std::function<Status(const Update&)>& use) {
  if (const auto* set = std::get_if<SetTransforms>(&update);
      set != nullptr && set->nodes.size() > kTransformsPerUpdate) {
    for (std::size_t i = 0; i < set->nodes.size(); i += kTransformsPerUpdate) {
      const SetTransforms part{part_of(set->nodes, i, kTransformsPerUpdate),
                               part_of(set->parent_from_local, i, kTransformsPerUpdate)};
      if (Status used = use(part); !used) return used;
    }
    return {};
  }
  if (const auto* patch = std::get_if<PatchVertices>(&update);
      patch != nullptr && patch->positions.size() > kVerticesPerUpdate) {
    for (std::size_t i = 0; i < patch->positions.size(); i += kVerticesPerUpdate) {
      const PatchVertices part{patch->nodes, patch->first + static_cast<std::uint32_t>(i),
                               part_of(patch->positions, i, kVerticesPerUpdate)};
      if (Status used = use(part); !used) return used;
    }
    return {};
  }
  return use(update);
}

}  // namespace sightline::client::wire
