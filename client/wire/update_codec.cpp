// Field by field, arrays as their bytes.
#include "client/wire/update_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <variant>

#include "client/wire/scene_codec.h"

namespace sightline::client::wire {
namespace {

constexpr std::size_t kTransformsPerUpdate = 4096;  // 96 bytes each, and a reference
constexpr std::size_t kVerticesPerUpdate = 65536;   // 12 bytes each

static_assert(sizeof(Transform) == 96 && sizeof(Vertex) == 12, "columns are the arrays' bytes");

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

// False if the bytes are no whole number of rows.
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
  return out;
}

// The rows of `list` from `first` on, at most n.
template <class T>
std::vector<T> part_of(const std::vector<T>& list, std::size_t first, std::size_t n) {
  const auto from = list.begin() + static_cast<std::ptrdiff_t>(first);
  return {from, from + static_cast<std::ptrdiff_t>(std::min(n, list.size() - first))};
}

}  // namespace

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
