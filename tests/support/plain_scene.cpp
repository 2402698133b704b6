// A scene in the simplest representation.
#include "tests/support/plain_scene.h"

#include <algorithm>
#include <utility>

namespace sightline::tests {

using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using scenegraph::model::NodeId;
using scenegraph::model::NodeRef;

namespace {

Affine product(const Affine& outer, const Affine& inner) {
  Affine result;
  for (std::size_t r = 0; r < 12; r += 4) {
    for (std::size_t c = 0; c < 4; ++c) {
      result.m[r + c] = outer.m[r] * inner.m[c] + outer.m[r + 1] * inner.m[4 + c] +
                        outer.m[r + 2] * inner.m[8 + c] + (c == 3 ? outer.m[r + 3] : 0);
    }
  }
  return result;
}

}  // namespace

accel::geometry::MeshView PlainNode::view() const {
  const accel::geometry::MeshView as_put = mesh->view();
  return vertices ? accel::geometry::MeshView{*vertices, as_put.faces} : as_put;
}

std::uint64_t PlainScene::triangles() const {
  std::uint64_t sum = 0;
  for (const auto& [id, node] : nodes_) sum += node.mesh ? node.mesh->triangles() : 0;
  return sum;
}

int PlainScene::depth(NodeId id) const {
  int depth = 0;
  for (; id != 0; id = nodes_.at(id).parent) ++depth;
  return depth;
}

int PlainScene::height(NodeId id) const {
  int below = 0;
  for (const NodeId child : children(id)) below = std::max(below, height(child));
  return below + 1;
}

bool PlainScene::is_under(NodeId id, NodeId ancestor) const {
  while (id != 0 && id != ancestor) id = nodes_.at(id).parent;
  return id == ancestor;
}

std::vector<NodeId> PlainScene::children(NodeId parent) const {
  std::vector<NodeId> found;
  for (const auto& [id, node] : nodes_) {
    if (node.parent == parent) found.push_back(id);
  }
  return found;
}

Affine PlainScene::world_from_local(NodeId id) const {
  const PlainNode& node = nodes_.at(id);
  return node.parent == 0 ? node.parent_from_local
                          : product(world_from_local(node.parent), node.parent_from_local);
}

bool PlainScene::is_reached(NodeId id) const {
  if (is_flat(world_from_local(id))) return false;
  while (id != 0 && !is_flat(nodes_.at(id).parent_from_local)) id = nodes_.at(id).parent;
  return id == 0;
}

void PlainScene::apply(const scenegraph::model::Update& update) {
  if (const auto* u = std::get_if<scenegraph::model::PutNode>(&update)) {
    put(*u);
  } else if (const auto* m = std::get_if<scenegraph::model::SetTransforms>(&update)) {
    for (std::size_t i = 0; i < m->nodes.size(); ++i)
      nodes_.at(resolve(m->nodes[i])).parent_from_local = m->parent_from_local[i];
  } else if (const auto* p = std::get_if<scenegraph::model::PatchVertices>(&update)) {
    patch(*p);
  } else {
    remove(resolve(std::get<scenegraph::model::DeleteNode>(update).node));
  }
}

void PlainScene::publish() {
  ++revision_;
  aliases_.clear();
  put_nodes_.clear();
}

NodeId PlainScene::resolve(NodeRef ref) const {
  return ref < 0 ? aliases_.at(ref) : static_cast<NodeId>(ref);
}

NodeRef PlainScene::refer(NodeId id) const {
  for (const auto& [alias, made] : aliases_) {
    if (made == id) return alias;
  }
  return static_cast<NodeRef>(id);
}

void PlainScene::put(const scenegraph::model::PutNode& put) {
  if (put.node < 0 && !aliases_.contains(put.node)) aliases_[put.node] = next_id_++;
  const NodeId id = resolve(put.node);
  nodes_[id] = {put.parent == 0 ? 0 : resolve(put.parent),
                put.parent_from_local,
                put.mesh,
                put.mesh_digest,
                nullptr,
                put.mobility,
                put.mask};
  put_nodes_.push_back(id);
}

void PlainScene::patch(const scenegraph::model::PatchVertices& patch) {
  const auto before = nodes_.at(resolve(patch.nodes.front())).view().vertices;
  std::vector<Vec3f> after(before.begin(), before.end());
  std::copy(patch.positions.begin(), patch.positions.end(), after.begin() + patch.first);
  const auto shared = std::make_shared<const std::vector<Vec3f>>(std::move(after));
  for (const NodeRef ref : patch.nodes) nodes_.at(resolve(ref)).vertices = shared;
}

void PlainScene::remove(NodeId id) {
  for (const NodeId child : children(id)) remove(child);
  nodes_.erase(id);
}

std::vector<PlacedMesh> PlainScene::placed() const {
  std::vector<PlacedMesh> placed;
  for (const auto& [id, node] : nodes_) {
    if (node.mesh && is_reached(id))
      placed.push_back({node.view(), world_from_local(id), id, node.mask});
  }
  return placed;
}

std::vector<NodeId> PlainScene::hidden(NodeId root, std::span<const NodeId> excluded) const {
  std::vector<NodeId> hidden;
  for (const auto& [id, node] : nodes_) {
    const NodeId self = id;
    const bool out =
        std::any_of(excluded.begin(), excluded.end(), [&](NodeId e) { return is_under(self, e); });
    if (out || (root != 0 && !is_under(id, root))) hidden.push_back(id);
  }
  return hidden;
}

}  // namespace sightline::tests
