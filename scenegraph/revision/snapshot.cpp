// Meshes, bounds and summaries of a revision.
#include "scenegraph/revision/snapshot.h"

#include <limits>
#include <unordered_set>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/instances/flat_scene.h"
#include "scenegraph/revision/levels.h"

namespace sightline::scenegraph::revision {
namespace {

/// Bounds are taken over vertices up to this many triangles, beyond that over the meshes' boxes.
constexpr std::uint64_t kExactBoundsTriangles = 50'000'000;

void grow_by_triangles(WorldBounds& bounds, const model::Mesh& mesh, const model::Affine& world) {
  mesh.with_arrays([&](const accel::geometry::MeshView& view) {
    for (std::size_t i = 0; i < view.faces.size(); ++i) {
      if (!accel::mesh::face_bounds(view, i)) continue;
      for (const std::uint32_t v : view.faces[i])
        bounds.grow(world.point(accel::geometry::Vec3d(view.vertices[v])));
    }
  });
}

void grow_by_box(WorldBounds& bounds, const model::Mesh& mesh, const model::Affine& world) {
  const model::DoubleBox box = mapped(world, model::DoubleBox(mesh.bounds()));
  bounds.grow(box.lo);
  bounds.grow(box.hi);
}

}  // namespace

Snapshot::Snapshot(std::uint64_t revision, const hierarchy::Hierarchy& hierarchy)
    : Snapshot(revision, hierarchy, new_trees(hierarchy, revision)) {}

std::vector<const model::Mesh*> Snapshot::meshes() const {
  std::vector<const model::Mesh*> meshes;
  std::unordered_set<const model::Mesh*> seen;
  nodes().for_each([&](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    const model::Mesh* mesh = node->mesh.get();
    if (mesh != nullptr && seen.insert(mesh).second) meshes.push_back(mesh);
  });
  return meshes;
}

const WorldBounds& Snapshot::bounds() const {
  std::call_once(bounds_once_, [this] {
    const std::uint64_t triangles = hierarchy_.summary(0).triangles;
    hierarchy::for_each_reached(
        hierarchy_, [&](const model::Node& node, const model::Affine& world, const model::Affine&) {
          if (triangles <= kExactBoundsTriangles) {
            grow_by_triangles(bounds_, *node.mesh, world);
          } else {
            grow_by_box(bounds_, *node.mesh, world);
          }
        });
  });
  return bounds_;
}

SceneSummary summarize(const Snapshot& snapshot) {
  SceneSummary s;
  s.revision = snapshot.revision();
  s.nodes = snapshot.node_count();
  const hierarchy::NodeSummary all = snapshot.hierarchy().summary(0);
  s.instances = all.mesh_nodes;
  s.triangles_instanced = all.triangles;
  std::unordered_set<const model::Mesh*> seen;
  snapshot.nodes().for_each([&](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    const model::Mesh* mesh = node->mesh.get();
    if (mesh == nullptr || !seen.insert(mesh).second) return;
    ++s.meshes;
    s.triangles_unique += mesh->triangles();
    s.triangles_nonfinite += mesh->nonfinite();
    s.bytes_geometry += mesh->bytes();
  });
  const WorldBounds& b = snapshot.bounds();
  s.bounds = {b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z};
  if (b.empty()) s.bounds.fill(std::numeric_limits<double>::quiet_NaN());
  return s;
}

BuildSummary summarize_build(const Snapshot& snapshot) {
  BuildSummary s;
  const hierarchy::NodeSummary all = snapshot.hierarchy().summary(0);
  s.instances_total = all.mesh_nodes;
  for (const model::NodeId id : instances::topmost_dynamic_roots(snapshot.hierarchy()))
    s.dynamic_instances += snapshot.hierarchy().summary(id).mesh_nodes;
  s.static_instances = all.mesh_nodes - s.dynamic_instances;
  const instances::Instances* all_static =
      snapshot.shared_trees().static_tree()->instances_so_far();
  const auto flat = all_static == nullptr ? nullptr : all_static->flat();
  if (flat != nullptr) s.cells_expanded += flat->triangles().tree().growth().cells_built;
  std::unordered_set<const model::Mesh*> seen;
  snapshot.nodes().for_each([&](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    const model::Mesh* mesh = node->mesh.get();
    if (mesh == nullptr) return;
    if (node->entered->load(std::memory_order_relaxed)) ++s.instances_entered;
    if (!seen.insert(mesh).second) return;
    s.triangles_total += mesh->triangles();
    if (!mesh->is_resident()) {
      s.cells_deferred += mesh->bounds().empty() ? 0 : 1;
      return;
    }
    const accel::kdtree::EpochPin pin;
    const accel::kdtree::GrowthMetrics growth = mesh->tree().growth();
    const bool is_flat = flat != nullptr && flat->has(mesh);
    s.trees_built += is_flat || growth.references_built > 0 ? 1 : 0;
    s.cells_deferred += is_flat ? 0 : growth.cells_deferred;
    s.cells_expanded += growth.cells_built;
    s.triangles_built += is_flat ? mesh->triangles() - mesh->nonfinite() : growth.references_built;
    s.bytes_geometry += mesh->bytes();
    s.bytes_trees += mesh->tree().bytes();
    if (const accel::kdtree::KdTree* kd = mesh->tree().kd()) {
      s.bytes_lists += kd->deferred_bytes();
      s.bytes_wide_nodes += kd->finished_bytes();
    }
  });
  const accel::kdtree::EpochPin pin;
  for (const instances::Level& level : snapshot.shared_trees().levels) {
    const instances::Instances* opened = level.tree->instances_so_far();
    if (opened == nullptr) continue;
    (level.tree->is_static() ? s.bytes_static_tree : s.bytes_dynamic_tree) += opened->tree_bytes();
  }
  s.bytes_trees += s.bytes_static_tree + s.bytes_dynamic_tree;
  return s;
}

}  // namespace sightline::scenegraph::revision
