// The end-point overlap of hierarchies whose values can be computed by hand.
#include "tests/bench/verbs/end_point_overlap.h"

#include <gtest/gtest.h>

#include <vector>

#include "accel/published/bvh/bvh_builder.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/bvh_measure.h"
#include "tests/support/scenes.h"

namespace sightline::bench {
namespace {

accel::kdtree::Reference ref(std::uint32_t id, const accel::geometry::Aabb& box) {
  return {box.lo, id, box.hi, 1};
}

TEST(EndPointOverlap, CountsTheAreaOfForeignTrianglesInABox) {
  // Halves of three squares in planes of constant x; the first leaf's box also contains the third.
  tests::TestMesh mesh;
  for (const float x : {0.0f, 1.0f, 0.5f}) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x, 1, 0}, {x, 0, 1}});
    mesh.faces.push_back({n, n + 1, n + 2});
  }
  accel::published::bvh::BvhGrowth growth(3);
  const accel::geometry::Aabb left{{0, 0, 0}, {1, 1, 1}}, right{{0.5f, 0, 0}, {0.5f, 1, 1}};
  const std::vector<accel::kdtree::Reference> two{ref(0, left), ref(1, left)}, one{ref(2, right)};
  const accel::published::bvh::Bvh bvh =
      growth.finish(growth.inner(growth.leaf(two, left), growth.leaf(one, right)));
  // One third of the total area lies in the box of a leaf of two references.
  EXPECT_DOUBLE_EQ(end_point_overlap(bvh, mesh.view()), 2 * accel::kdtree::kMeasuredIntersect / 3);
}

TEST(EndPointOverlap, IsZeroForDisjointBoxes) {
  tests::TestMesh mesh = tests::flat_walls(64);
  accel::kdtree::BuildCounters counters;
  const accel::published::bvh::Bvh bvh =
      accel::published::bvh::BvhBuilder{.leaf = {.leaf_size = 2}}.build(mesh.view(), counters);
  EXPECT_EQ(measure(bvh).overlap, 0);
  EXPECT_EQ(end_point_overlap(bvh, mesh.view()), 0);
}

}  // namespace
}  // namespace sightline::bench
