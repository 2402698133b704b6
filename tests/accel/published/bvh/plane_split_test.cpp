// Splitting by a plane: the parts cover all of a triangle, and some triangles are kept whole.
#include "accel/published/bvh/plane_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "accel/geometry/clip.h"
#include "tests/accel/published/bvh/fragments.h"
#include "tests/support/random.h"

namespace sightline::accel::published::bvh {
namespace {

using Goes = Straddler::Goes;
using tests::SortedFragments;
using tests::TestMesh;

SpatialSplit middle_of(const CenterLists& lists, std::size_t axis) {
  return {axis, 0.5f * lists.box.lo[axis] + 0.5f * lists.box.hi[axis], 0, 0, 0};
}

PlaneSplit plan(const TestMesh& mesh, const CenterLists& lists, std::size_t axis, bool unsplit) {
  PlaneSplit split;
  kdtree::BuildCounters counters;
  plan_plane_split(mesh.view(), lists, middle_of(lists, axis), unsplit, split, counters);
  return split;
}

/// Section 4.4 of the paper, computed from scratch.
std::map<std::uint32_t, Goes> decided_naively(const CenterLists& lists, const PlaneSplit& all) {
  std::map<std::uint32_t, Goes> goes;
  std::map<std::uint32_t, const Straddler*> parts;
  for (const Straddler& s : all.straddlers) {
    goes[s.whole.order()] = s.goes;
    parts[s.whole.order()] = &s;
  }
  for (const auto& [order, straddler] : parts) {
    if (straddler->goes != Goes::kBoth) continue;
    geometry::Aabb left, right;
    double n_left = 0, n_right = 0;
    for (const Fragment& f : lists.along[1]) {
      const auto s = parts.find(f.order());
      if (s == parts.end()) {
        const bool below = f.hi[all.axis] <= all.position;
        (below ? left : right).grow(f.bounds());
        ++(below ? n_left : n_right);
        continue;
      }
      const Goes g = goes[f.order()];
      // A fragment cut on both sides stays in the box that it is removed from.
      const bool cut = s->second->goes == Goes::kBoth;
      if (cut || g == Goes::kLeft) left.grow(s->second->left);
      if (cut || g == Goes::kRight) right.grow(s->second->right);
      if (cut && g == Goes::kLeft) left.grow(f.bounds());
      if (cut && g == Goes::kRight) right.grow(f.bounds());
      n_left += g != Goes::kRight ? 1 : 0;
      n_right += g != Goes::kLeft ? 1 : 0;
    }
    geometry::Aabb left_with = left, right_with = right;
    left_with.grow(straddler->whole.bounds());
    right_with.grow(straddler->whole.bounds());
    const double split = half_area(left) * n_left + half_area(right) * n_right;
    const double to_left = half_area(left_with) * n_left + half_area(right) * (n_right - 1);
    const double to_right = half_area(left) * (n_left - 1) + half_area(right_with) * n_right;
    if (to_left < split && to_left <= to_right && n_right > 1) {
      goes[order] = Goes::kLeft;
    } else if (to_right < split && n_left > 1) {
      goes[order] = Goes::kRight;
    }
  }
  return goes;
}

TEST(PlaneSplit, KeepsWholeIfThatIsCheaper) {
  int kept = 0, cut = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const TestMesh mesh = tests::random_soup(10 + 3 * static_cast<std::uint32_t>(seed), 0.4, seed);
    const SortedFragments sorted(tests::face_refs(mesh));
    for (const std::size_t axis : {0u, 1u, 2u}) {
      const PlaneSplit all = plan(mesh, sorted.lists, axis, false);
      const PlaneSplit some = plan(mesh, sorted.lists, axis, true);
      const auto expected = decided_naively(sorted.lists, all);
      ASSERT_EQ(some.straddlers.size(), expected.size());
      for (const Straddler& s : some.straddlers) {
        EXPECT_EQ(s.goes, expected.at(s.whole.order()));
        ++(s.goes == Goes::kBoth ? cut : kept);
      }
      EXPECT_LE(some.sum(), all.sum());
    }
  }
  EXPECT_GT(kept, 100);
  EXPECT_GT(cut, 100);
}

TEST(PlaneSplit, ChildrenCoverEveryTriangle) {
  tests::Random random(4);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TestMesh mesh = tests::random_soup(100, 0.5, seed);
    SortedFragments sorted(tests::face_refs(mesh));
    const PlaneSplit split = plan(mesh, sorted.lists, seed % 3, seed % 2 == 0);
    EXPECT_TRUE(split.reduces(sorted.lists));
    std::vector<Fragment> fragments(3 * split.right);
    const std::size_t size = sorted.lists.size();
    const ListHalves halves =
        divide_by_plane(sorted.lists, split, fragments.data(), sorted.counters);
    EXPECT_EQ(halves.left.size() + halves.right.size(), size + split.added(size));
    std::map<std::uint32_t, std::vector<geometry::Aabb>> parts;
    for (const CenterLists* half : {&halves.left, &halves.right}) {
      for (const std::size_t axis : {0u, 1u, 2u}) {
        ASSERT_TRUE(tests::is_sorted_along(half->along[axis], axis));
        ASSERT_EQ(box_around(half->along[axis]), half->box);
        ASSERT_EQ(half->along[axis].size(), half->size());
      }
      for (const Fragment& f : half->along[2]) parts[f.id()].push_back(f.bounds());
    }
    for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) {
      const geometry::Face& f = mesh.faces[i];
      for (int k = 0; k < 20; ++k) {
        const double u = random.uniform(), v = random.uniform(0, 1 - u);
        const geometry::Vec3d p = geometry::Vec3d(mesh.vertices[f[0]]) * (1 - u - v) +
                                  geometry::Vec3d(mesh.vertices[f[1]]) * u +
                                  geometry::Vec3d(mesh.vertices[f[2]]) * v;
        const auto holds = [&](const geometry::Aabb& box) {
          for (std::size_t a = 0; a < 3; ++a) {
            if (p[a] < static_cast<double>(box.lo[a]) - 1e-14 ||
                p[a] > static_cast<double>(box.hi[a]) + 1e-14)
              return false;
          }
          return true;
        };
        ASSERT_TRUE(std::any_of(parts[i].begin(), parts[i].end(), holds));
      }
    }
  }
}

TEST(PlaneSplit, OneSidedPartsAreNoStraddlers) {
  // A triangle whose box crosses the plane only with a corner that an earlier cut has removed.
  const TestMesh mesh{{{0, 0, 0}, {4, 4, 0}, {0, 4, 0}}, {{0, 1, 2}}};
  FragmentStack stack;
  std::vector<kdtree::Reference> refs{{{0, 0, 0}, 0, {3, 1, 1e-3f}, 1}};
  kdtree::BuildCounters counters;
  const CenterLists lists = sort_by_centers(refs, stack, counters);
  PlaneSplit split;
  plan_plane_split(mesh.view(), lists, {0, 2.0f, 1, 1, 0}, true, split, counters);
  ASSERT_EQ(split.straddlers.size(), 1u);
  EXPECT_EQ(split.straddlers[0].goes, Goes::kLeft);
  EXPECT_EQ(split.left, 1u);
  EXPECT_EQ(split.right, 0u);
  EXPECT_FALSE(split.reduces(lists));
}

}  // namespace
}  // namespace sightline::accel::published::bvh
