// Scenes of a row of nodes, and checks of what rays meet in them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::scenegraph::revision {

inline model::Affine at(double x, double y = 0, double z = 0) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

inline model::PutNode mesh_node(model::NodeRef alias, double x,
                                model::Mobility mobility = model::Mobility::kStatic,
                                model::NodeRef parent = 0) {
  model::PutNode put;
  put.node = alias;
  put.parent = parent;
  put.parent_from_local = at(x);
  put.mesh = tests::some_mesh(0);
  put.mobility = mobility;
  return put;
}

/// Static nodes 1 .. count in a row along x, ten units apart.
inline void add_row(Scene& scene, int count) {
  std::vector<model::Update> updates;
  for (int i = 1; i <= count; ++i) updates.emplace_back(mesh_node(-i, 10.0 * i));
  ASSERT_TRUE(scene.apply(updates));
}

inline std::vector<accel::geometry::Hit> hits_in(const Snapshot& snapshot,
                                                 const std::vector<accel::geometry::Ray>& rays,
                                                 TraceStats* stats = nullptr) {
  std::vector<accel::geometry::Hit> hits(rays.size());
  const auto traced = trace(snapshot, rays, hits, {});
  EXPECT_TRUE(traced);
  if (stats != nullptr) *stats = *traced;
  return hits;
}

/// Hits equal those of brute force, and are the same to the bit in new trees.
inline void expect_as_oracle(const std::shared_ptr<const Snapshot>& snapshot, std::uint64_t seed) {
  const std::vector<accel::geometry::Ray> rays = tests::rays_through(*snapshot, 300, seed);
  const std::vector<accel::geometry::Hit> hits = hits_in(*snapshot, rays);
  const tests::BruteForce oracle(snapshot);
  const auto compared = tests::compare(rays, hits, oracle);
  EXPECT_TRUE(compared.clean()) << compared.report();
  const Snapshot afresh(snapshot->revision(), snapshot->hierarchy());
  const auto again = hits_in(afresh, rays);
  EXPECT_TRUE(std::equal(hits.begin(), hits.end(), again.begin(), again.end(),
                         [](const accel::geometry::Hit& a, const accel::geometry::Hit& b) {
                           return a.t == b.t && a.node == b.node && a.primitive == b.primitive &&
                                  a.u == b.u && a.v == b.v && a.normal == b.normal &&
                                  a.state == b.state;
                         }));
}

}  // namespace sightline::scenegraph::revision
