// A mesh as one wide tree, and packets of rays through it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <vector>

#include "accel/blocks/block_builder.h"
#include "accel/geometry/local_ray.h"
#include "accel/geometry/ray.h"
#include "accel/mesh/face_boxes.h"
#include "accel/wide/exact.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/walk.h"
#include "accel/wide/wide_tree.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// All vertices are finite, and in sizes for leaf blocks.
struct MeshAsTree {
  explicit MeshAsTree(TestMesh from) : mesh(std::move(from)) {
    std::vector<accel::kdtree::Reference> refs(mesh.faces.size());
    refs.resize(accel::mesh::face_references(mesh.view(), 0, refs.size(), refs.data()));
    for (const accel::kdtree::Reference& ref : refs) bounds.grow(ref.bounds());
    frame = accel::wide::frame_of(bounds);
    accel::blocks::Arena arena;
    const accel::blocks::Node* root =
        accel::blocks::BlockBuilder(mesh.view(), frame.center).build(refs, bounds, arena);
    tree = std::make_unique<accel::wide::WideTree>(*root, frame.center);
  }

  TestMesh mesh;
  accel::geometry::Aabb bounds;
  accel::wide::Frame frame;
  std::unique_ptr<accel::wide::WideTree> tree;
};

/// The rays of a packet; the lanes behind them stay unused. All rays are valid.
inline void set_rays(std::span<const accel::geometry::Ray> rays, accel::wide::Rays& out) {
  for (std::size_t i = 0; i < accel::wide::kLanes; ++i) {
    const accel::geometry::Ray& ray = rays[std::min(i, rays.size() - 1)];
    const accel::geometry::LocalRay local =
        *accel::geometry::make_local_ray(ray.origin, ray.direction);
    for (std::size_t a = 0; a < 3; ++a) {
      out.origin[a][i] = local.origin[a];
      out.direction[a][i] = local.direction[a];
    }
    out.unit[i] = local.unit;
    out.tmin[i] = ray.tmin;
    out.tmax[i] = ray.tmax;
  }
}

/// Leaf policy.
struct NoSlots {
  static accel::wide::Child enter(accel::kdtree::AtomicSlot&, std::uint32_t) {
    ADD_FAILURE() << "a tree without slots";
    return {};
  }
  static void visit(std::span<const std::uint32_t>, std::uint32_t) {
    ADD_FAILURE() << "a tree without lists";
  }
};

}  // namespace sightline::tests
