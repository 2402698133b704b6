// Drawing updates.
#include "tests/support/random_edits.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "tests/support/scenes.h"

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using scenegraph::model::Mobility;
using scenegraph::model::NodeId;
using scenegraph::model::NodeRef;
using scenegraph::model::PutNode;

namespace {

constexpr std::size_t kFewNodes = 12, kManyNodes = 40;
constexpr int kDeep = 7;
constexpr double kReach = 5;
constexpr NodeRef kUnknownNode = 1'000'000'000'000;

PutNode same_again(const PlainScene& scene, NodeId id) {
  const PlainNode& node = scene.nodes().at(id);
  PutNode put;
  put.node = scene.refer(id);
  put.parent = node.parent == 0 ? 0 : scene.refer(node.parent);
  put.parent_from_local = node.parent_from_local;
  put.mesh = node.mesh;
  put.mesh_digest = node.mesh_digest;
  put.mobility = node.mobility;
  put.mask = node.mask;
  return put;
}

}  // namespace

std::vector<MeshChoice> small_meshes() {
  std::vector<MeshChoice> choices;
  for (const TestMesh& mesh : {planar_sheet(1), icosphere(1), icosphere(2), cube(), planar_sheet(6),
                               staircase(8), random_soup(60, 0.3, 3), random_soup(200, 0.1, 4)}) {
    choices.push_back({*scenegraph::model::Mesh::make(mesh.vertices, mesh.faces), ""});
  }
  return choices;
}

RandomEdit ground(const std::vector<MeshChoice>& meshes) {
  RandomEdit edit;
  const auto put = [&](const PutNode& node) {
    edit.updates.emplace_back(node);
    edit.after.apply(node);
  };
  PutNode node;
  node.node = -1;
  put(node);
  node.parent = -1;
  for (std::size_t i = 0; i < kGround; ++i) {
    node.node = -2 - static_cast<NodeRef>(i);
    node.parent_from_local.m[3] = static_cast<double>(i % 20) - 10;
    node.parent_from_local.m[7] = static_cast<double>(i / 20) - 7;
    node.mesh = meshes.front().mesh;
    node.mesh_digest = meshes.front().digest;
    put(node);
  }
  edit.put_nodes = edit.after.put_nodes();
  edit.after.publish();
  return edit;
}

struct RandomEdits::Batch {
  std::vector<scenegraph::model::Update> updates;
  PlainScene scene;  // After all updates of the batch
  NodeRef next_alias = -1;

  void add(scenegraph::model::Update update) {
    scene.apply(update);
    updates.push_back(std::move(update));
  }
};

RandomEdit RandomEdits::next(const PlainScene& now) {
  Batch batch{{}, now};
  for (std::uint64_t n = 1 + random_.below(4); n > 0; --n) edit(batch);
  RandomEdit drawn;
  if (random_.below(6) == 0) drawn.refusal = spoil(batch);
  drawn.put_nodes = batch.scene.put_nodes();
  batch.scene.publish();
  drawn.after = std::move(batch.scene);
  drawn.updates = std::move(batch.updates);
  return drawn;
}

void RandomEdits::edit(Batch& batch) {
  const auto beside =
      std::distance(batch.scene.nodes().upper_bound(kGround + 1), batch.scene.nodes().end());
  const auto nodes = static_cast<std::size_t>(beside);
  if (nodes < kFewNodes) return put_group(batch);
  if (nodes > kManyNodes) return remove(batch);
  switch (random_.below(10)) {
    case 0:
      return put_group(batch);
    case 1: {
      const NodeId parent = *pick(batch.scene, false);
      return put_new(batch, batch.scene.depth(parent) < kDeep ? batch.scene.refer(parent) : 0,
                     random_.below(6) == 0);
    }
    case 2:
      return remove(batch);
    case 3:
    case 4:
      return change(batch);
    case 5:
    case 6:
      return patch(batch);
    default:
      return move(batch);
  }
}

// A random rotation, a mild scale, sometimes a mirror, and rarely flat.
Affine RandomEdits::frame() {
  Vec3d x = random_.direction();
  Vec3d y = cross(x, random_.direction());
  y = y * (1 / std::sqrt(dot(y, y)));
  Vec3d z = cross(x, y);
  if (random_.below(5) == 0) z = z * -1.0;
  const std::uint64_t flat = random_.below(30);
  if (flat == 0) z = {};
  if (flat == 1) x = y = z = {};
  const double s = random_.uniform(0.7, 1.4);
  const auto at = [&] { return random_.uniform(-kReach, kReach); };
  return {{s * x.x, s * y.x, s * z.x, at(), s * x.y, s * y.y, s * z.y, at(), s * x.z, s * y.z,
           s * z.z, at()}};
}

Mobility RandomEdits::mobility() {
  constexpr Mobility kAll[] = {Mobility::kStatic, Mobility::kRigid, Mobility::kDeforming};
  return kAll[random_.below(3)];
}

std::optional<NodeId> RandomEdits::pick(const PlainScene& scene, bool with_mesh) {
  const bool anywhere = random_.below(8) == 0;
  std::vector<NodeId> ids;
  for (const auto& [id, node] : scene.nodes()) {
    if ((anywhere || id > kGround + 1) && (!with_mesh || node.mesh)) ids.push_back(id);
  }
  if (ids.empty()) return std::nullopt;
  return ids[random_.below(ids.size())];
}

void RandomEdits::put_new(Batch& batch, NodeRef parent, bool group) {
  PutNode put;
  put.node = batch.next_alias--;
  put.parent = parent;
  put.parent_from_local = frame();
  if (!group) {
    const MeshChoice& choice = mesh();
    put.mesh = choice.mesh;
    put.mesh_digest = choice.digest;
  }
  put.mobility = mobility();
  if (random_.below(4) == 0) put.mask = 1u << random_.below(3);
  batch.add(put);
}

// A node and some descendants, named by aliases.
void RandomEdits::put_group(Batch& batch) {
  const NodeRef group = batch.next_alias;
  put_new(batch, 0, random_.below(2) == 0);
  for (std::uint64_t n = 1 + random_.below(3); n > 0; --n) put_new(batch, group, false);
}

// Another parent, mask, mobility or mesh.
void RandomEdits::change(Batch& batch) {
  const NodeId id = *pick(batch.scene, false);
  PutNode put = same_again(batch.scene, id);
  const std::uint64_t what = random_.below(4);
  if (what == 0) {
    const NodeId parent = *pick(batch.scene, false);
    const bool allowed = !batch.scene.is_under(parent, id) &&
                         batch.scene.depth(parent) + batch.scene.height(id) <= kDeep;
    put.parent = allowed ? batch.scene.refer(parent) : 0;
  } else if (what == 1) {
    put.mask = random_.below(2) == 0 ? accel::geometry::kAllMasks : 1u << random_.below(3);
  } else if (what == 2) {
    put.mobility = mobility();
  } else {
    const MeshChoice& choice = mesh();
    put.mesh = choice.mesh;
    put.mesh_digest = choice.digest;
  }
  batch.add(put);
}

void RandomEdits::move(Batch& batch) {
  scenegraph::model::SetTransforms set;
  for (std::uint64_t n = 1 + random_.below(8); n > 0; --n) {
    // Sometimes the ground itself.
    const bool whole = random_.below(100) == 0 && batch.scene.nodes().contains(1);
    const NodeId id = whole ? 1 : *pick(batch.scene, false);
    set.nodes.push_back(batch.scene.refer(id));
    set.parent_from_local.push_back(frame());
  }
  batch.add(std::move(set));
}

// Patches one node or several that share its mesh, some vertices or all.
void RandomEdits::patch(Batch& batch) {
  const auto id = pick(batch.scene, true);
  if (!id) return;
  const PlainNode& node = batch.scene.nodes().at(*id);
  scenegraph::model::PatchVertices patch;
  for (const auto& [other, other_node] : batch.scene.nodes()) {
    const bool shares = other_node.mesh && other_node.same_mesh(node);
    if (other == *id || (shares && random_.below(2) == 0))
      patch.nodes.push_back(batch.scene.refer(other));
  }
  const auto vertices = node.view().vertices;
  patch.first = static_cast<std::uint32_t>(random_.below(vertices.size()));
  const std::size_t count = 1 + random_.below(vertices.size() - patch.first);
  for (const Vec3f& v : vertices.subspan(patch.first, count))
    patch.positions.push_back(v + Vec3f(random_.direction() * 0.2));
  batch.add(std::move(patch));
}

void RandomEdits::remove(Batch& batch) {
  const NodeId id = *pick(batch.scene, false);
  const int height = batch.scene.height(id);
  if (height > 3 || (id <= kGround + 1 && (height > 1 || random_.below(8) != 0))) return;
  batch.add(scenegraph::model::DeleteNode{batch.scene.refer(id), height > 1});
}

// Adds an update for which the batch must be refused.
Code RandomEdits::spoil(Batch& batch) {
  const auto id = pick(batch.scene, true);
  const std::uint64_t what = id ? random_.below(6) : 0;
  if (what == 0) {
    batch.updates.push_back(scenegraph::model::SetTransforms{{kUnknownNode}, {Affine{}}});
    return Code::kNotFound;
  }
  const NodeRef ref = batch.scene.refer(*id);
  if (what == 1) {
    PutNode put = same_again(batch.scene, *id);
    put.parent = ref;
    batch.updates.push_back(put);
  } else if (what == 2) {
    Affine bad;
    bad.m[random_.below(12)] = std::numeric_limits<double>::quiet_NaN();
    batch.updates.push_back(scenegraph::model::SetTransforms{{ref}, {bad}});
  } else if (what == 3) {
    const auto vertices = batch.scene.nodes().at(*id).view().vertices.size();
    batch.updates.push_back(
        scenegraph::model::PatchVertices{{ref}, static_cast<std::uint32_t>(vertices), {Vec3f{}}});
  } else if (what == 4) {
    batch.updates.push_back(scenegraph::model::SetTransforms{{ref, ref}, {Affine{}}});
  } else {
    NodeId parent = *id;
    while (batch.scene.nodes().at(parent).parent != 0)
      parent = batch.scene.nodes().at(parent).parent;
    if (batch.scene.height(parent) == 1) {
      batch.updates.push_back(scenegraph::model::PatchVertices{});
      return Code::kInvalidArgument;
    }
    batch.updates.push_back(scenegraph::model::DeleteNode{batch.scene.refer(parent), false});
    return Code::kFailedPrecondition;
  }
  return Code::kInvalidArgument;
}

}  // namespace sightline::tests
