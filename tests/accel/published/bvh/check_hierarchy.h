// Checks the invariants of every bounding volume hierarchy: boxes contain everything below them,
// and the leaves that list a triangle cover all of it together.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "accel/mesh/face_boxes.h"
#include "accel/published/bvh/bvh.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline bool holds_box(const accel::geometry::Aabb& outer, const accel::geometry::Aabb& inner) {
  accel::geometry::Aabb both = outer;
  both.grow(inner);
  return both == outer;
}

struct HierarchyLeaf {
  accel::geometry::Aabb box;
  std::vector<std::uint32_t> ids;
};

/// Checks order, depth and boxes; collects the leaves.
inline void collect_leaves(const accel::published::bvh::Bvh& bvh,
                           const accel::published::bvh::BvhChild& at, int depth,
                           std::size_t& next_node, std::size_t& next_id,
                           std::vector<HierarchyLeaf>& leaves) {
  ASSERT_LE(depth, accel::published::bvh::kMaxBvhDepth);
  if (!at.inner) {
    ASSERT_EQ(at.first, at.count > 0 ? next_id : at.first);
    next_id += at.count;
    const auto ids = bvh.leaf(at);
    leaves.push_back({at.box, {ids.begin(), ids.end()}});
    std::vector<std::uint32_t> sorted(ids.begin(), ids.end());
    std::sort(sorted.begin(), sorted.end());
    ASSERT_TRUE(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
    return;
  }
  ASSERT_EQ(at.first, next_node++);
  for (const std::size_t side : {0u, 1u}) {
    const accel::published::bvh::BvhChild child = bvh.nodes[at.first].child(side);
    ASSERT_TRUE(holds_box(at.box, child.box));
    collect_leaves(bvh, child, depth + 1, next_node, next_id, leaves);
  }
}

/// Tests random points of triangles: `tries` for each.
inline void check_hierarchy(const accel::published::bvh::Bvh& bvh, const TestMesh& mesh,
                            int tries = 8) {
  std::size_t nodes = 0, ids = 0;
  std::vector<HierarchyLeaf> leaves;
  collect_leaves(bvh, bvh.root, 0, nodes, ids, leaves);
  ASSERT_EQ(nodes, bvh.nodes.size());
  ASSERT_EQ(ids, bvh.ids.size());
  std::vector<std::vector<std::size_t>> naming(mesh.faces.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    for (const std::uint32_t id : leaves[i].ids) naming.at(id).push_back(i);
  }
  Random random(5);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (!accel::mesh::face_bounds(mesh.view(), i)) {
      ASSERT_TRUE(naming[i].empty());
      continue;
    }
    const accel::geometry::Face& f = mesh.faces[i];
    for (int k = 0; k < tries; ++k) {
      const double u = k == 0 ? 1 : k == 1 ? 0 : random.uniform(0, 1);
      const double v = k == 1 ? 1 : random.uniform(0, 1 - u);
      const accel::geometry::Vec3d p = accel::geometry::Vec3d(mesh.vertices[f[0]]) * (1 - u - v) +
                                       accel::geometry::Vec3d(mesh.vertices[f[1]]) * u +
                                       accel::geometry::Vec3d(mesh.vertices[f[2]]) * v;
      const bool covered = std::any_of(naming[i].begin(), naming[i].end(), [&](std::size_t leaf) {
        const accel::geometry::Aabb& box = leaves[leaf].box;
        for (std::size_t a = 0; a < 3; ++a) {
          // The point is off by roundings of double, far below those of the box.
          const double off = 1e-14 * std::max(std::fabs(p[a]), 1e-300);
          if (p[a] < static_cast<double>(box.lo[a]) - off ||
              p[a] > static_cast<double>(box.hi[a]) + off)
            return false;
        }
        return true;
      });
      ASSERT_TRUE(covered) << "face " << i;
    }
  }
}

}  // namespace sightline::tests
