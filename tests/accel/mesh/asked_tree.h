// Trees over meshes, and what single rays find in them.
#pragma once

#include <memory>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/support/mesh_query.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline std::unique_ptr<accel::mesh::MeshTree> make_tree(
    const TestMesh& mesh,
    const accel::published::AnyBuilder& builder = accel::published::default_builder(),
    accel::mesh::References references = accel::mesh::References::kRuns) {
  return std::make_unique<accel::mesh::MeshTree>(
      mesh.view(), accel::mesh::compute_mesh_stats(mesh.view()), builder, references);
}

/// By one ray alone.
inline Answer ask(accel::mesh::MeshTree& tree, const accel::geometry::Ray& ray,
                  accel::lazy::Growth growth = accel::lazy::Growth::kFirstTouch) {
  const accel::kdtree::EpochPin pin;
  MeshQuery query = query_of(ray);
  query.cells.growth = growth;
  accel::kdtree::WalkCounters walked;
  accel::kdtree::BuildCounters built;
  ask(tree, query, walked, built);
  return query.found ? Answer{true, query.best_t, query.best_primitive} : Answer{};
}

}  // namespace sightline::tests
