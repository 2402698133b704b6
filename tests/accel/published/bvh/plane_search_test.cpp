// Chopped binning: the content of each bin against clipping to it, and the cheapest of all planes.
#include "accel/published/bvh/plane_search.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "accel/geometry/clip.h"
#include "accel/published/bvh/fragment_corners.h"
#include "tests/accel/published/bvh/fragments.h"
#include "tests/support/random.h"

namespace sightline::accel::published::bvh {
namespace {

using tests::SortedFragments;
using tests::TestMesh;

std::optional<geometry::Aabb> clipped(const geometry::MeshView& mesh, std::uint32_t face,
                                      const geometry::Aabb& cell) {
  const geometry::Face& f = mesh.faces[face];
  return clipped_bounds(mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]], cell);
}

/// A fragment of each face: its part in a random box, or all of it.
std::vector<Fragment> random_fragments(const TestMesh& mesh, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<Fragment> fragments;
  for (const kdtree::Reference& ref : tests::face_refs(mesh)) {
    geometry::Aabb part;
    const auto x = [&] { return static_cast<float>(random.uniform(-0.3, 1.3)); };
    part.grow(geometry::Vec3f{x(), x(), x()});
    part.grow(geometry::Vec3f{x(), x(), x()});
    const bool whole = random.below(3) == 0;
    const std::optional<geometry::Aabb> box =
        whole ? ref.bounds() : clipped(mesh.view(), ref.id, part);
    if (box) fragments.emplace_back(*box, ref.id, ref.id);
  }
  return fragments;
}

float plane(const geometry::Aabb& box, std::size_t axis, std::uint32_t i, std::uint32_t bins) {
  if (i == bins) return box.hi[axis];
  const auto lo = static_cast<double>(box.lo[axis]), hi = static_cast<double>(box.hi[axis]);
  return static_cast<float>(lo + (hi - lo) * (i / static_cast<double>(bins)));
}

void expect_near(const geometry::Aabb& a, const geometry::Aabb& b, double off) {
  ASSERT_EQ(a.empty(), b.empty());
  if (a.empty()) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(a.lo[axis], b.lo[axis], off);
    EXPECT_NEAR(a.hi[axis], b.hi[axis], off);
  }
}

/// The parts on the sides of a plane, clipped directly.
double clipped_sum(const geometry::MeshView& mesh, std::span<const Fragment> list, std::size_t axis,
                   float position) {
  std::array<geometry::Aabb, 2> box;
  std::array<double, 2> n{};
  for (const Fragment& f : list) {
    const geometry::HalvedCell halves = halve(f.bounds(), static_cast<int>(axis), position);
    for (const std::size_t side : {0u, 1u}) {
      const bool reaches = side == 0 ? f.lo[axis] < position : f.hi[axis] > position;
      if (!reaches) continue;
      n[side] += 1;
      const bool straddles = f.lo[axis] < position && f.hi[axis] > position;
      const std::optional<geometry::Aabb> part =
          straddles ? clipped(mesh, f.id(), side == 0 ? halves.left : halves.right) : f.bounds();
      if (part) box[side].grow(*part);
    }
  }
  if (n[0] == 0 || n[1] == 0) return std::numeric_limits<double>::infinity();
  return half_area(box[0]) * n[0] + half_area(box[1]) * n[1];
}

TEST(ChoppedAxis, EqualsClippingToEachBin) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const TestMesh mesh = tests::random_soup(40, 0.5, seed);
    for (const Fragment& f : random_fragments(mesh, seed)) {
      for (const std::size_t axis : {0u, 1u, 2u}) {
        std::array<float, 12> planes;
        for (std::uint32_t i = 0; i < planes.size(); ++i)
          planes[i] = static_cast<float>(-0.2 + 0.13 * i);
        ChoppedAxis bins(axis, planes);
        if (!bins.meets(f)) continue;
        const FragmentCorners corners(mesh.view(), f);
        bins.add(f, bins.span(f), corners.all());
        for (std::size_t i = 0; i < bins.bins(); ++i) {
          geometry::Aabb cell = f.bounds();
          cell.lo[axis] = std::max(cell.lo[axis], planes[i]);
          cell.hi[axis] = std::min(cell.hi[axis], planes[i + 1]);
          if (cell.empty() || cell.lo[axis] == cell.hi[axis]) continue;
          const std::optional<geometry::Aabb> part = clipped(mesh.view(), f.id(), cell);
          // A corner that barely reaches into a bin may be missed.
          const geometry::Aabb found = bins.bounds(i).aabb();
          if (found.empty() || !part) continue;
          expect_near(found, *part, 2e-6);
        }
      }
    }
  }
}

TEST(ChoppedAxis, CountsEntriesAndExits) {
  const std::array<float, 5> planes{0, 1, 2, 3, 4};
  ChoppedAxis bins(0, planes);
  const auto add = [&](float lo, float hi) {
    const Fragment f({{lo, 0, 0}, {hi, 1, 1}}, 0, 0);
    if (bins.meets(f)) bins.add(f, bins.span(f), {});
  };
  add(0, 1);  // Ends at a plane: below it
  add(1, 2);  // Begins at a plane: above it
  add(0.5f, 3.5f);
  add(-1, 0);  // Beyond
  add(-1, 5);
  add(4, 5);  // Beyond
  const ChoppedAxis::Sides sides = bins.sides({}, {});
  const std::array<std::size_t, 5> left{0, 2, 3, 3, 3}, right{3, 2, 1, 1, 0};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(sides.left[i].references, left[i]) << i;
    EXPECT_EQ(sides.right[i].references, right[i]) << i;
  }
}

TEST(PlaneSearch, FindsTheCheapestOfAllPlanes) {
  for (const std::uint32_t bins : {2u, 3u, 16u, 17u, 100u, 256u}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const TestMesh mesh = tests::random_soup(30, seed % 2 == 0 ? 0.9 : 0.1, seed + bins);
      const SortedFragments sorted(tests::face_refs(mesh));
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::uint32_t i = 1; i < bins; ++i) {
          least = std::min(least, clipped_sum(mesh.view(), sorted.lists.along[0], axis,
                                              plane(sorted.lists.box, axis, i, bins)));
        }
      }
      kdtree::BuildCounters counters;
      ListCorners corners;
      const SpatialSplit split =
          best_spatial_split(mesh.view(), sorted.lists, bins,
                             std::numeric_limits<double>::infinity(), corners, counters);
      ASSERT_TRUE(split.found());
      EXPECT_NEAR(split.sum, least, 1e-5 * least);
      EXPECT_NEAR(split.sum,
                  clipped_sum(mesh.view(), sorted.lists.along[0], split.axis, split.position),
                  1e-5 * least);
      EXPECT_FALSE(
          best_spatial_split(mesh.view(), sorted.lists, bins, 0.999 * least, corners, counters)
              .found());
    }
  }
}

TEST(PlaneSearch, ScansLongListsInSlices) {
  const TestMesh mesh = tests::random_soup(20'000, 0.2, 8);
  const SortedFragments sorted(tests::face_refs(mesh));
  kdtree::BuildCounters counters;
  ListCorners corners;
  const SpatialSplit split = best_spatial_split(
      mesh.view(), sorted.lists, 64, std::numeric_limits<double>::infinity(), corners, counters);
  ASSERT_TRUE(split.found());
  EXPECT_NEAR(split.sum,
              clipped_sum(mesh.view(), sorted.lists.along[0], split.axis, split.position),
              1e-5 * split.sum);
}

TEST(PlaneSearch, FindsNothingInANodeWithoutExtent) {
  // Its box has the extent that widen_flat gives to a point.
  const TestMesh mesh{{{1, 1, 1}}, {{0, 0, 0}, {0, 0, 0}}};
  const SortedFragments sorted(tests::face_refs(mesh));
  kdtree::BuildCounters counters;
  ListCorners corners;
  EXPECT_FALSE(best_spatial_split(mesh.view(), sorted.lists, 256,
                                  std::numeric_limits<double>::infinity(), corners, counters)
                   .found());
}

}  // namespace
}  // namespace sightline::accel::published::bvh
