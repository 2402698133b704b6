// Splitting before the build, by threshold and by number: the pieces cover all of a triangle.
#include "accel/published/bvh/pre_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/early_split.h"
#include "accel/published/bvh/edge_split.h"
#include "tests/accel/published/bvh/fragments.h"
#include "tests/support/random.h"

namespace sightline::accel::published::bvh {
namespace {

using tests::TestMesh;
using Split = std::vector<kdtree::Reference> (*)(const geometry::MeshView&,
                                                 std::vector<kdtree::Reference>,
                                                 const PreSplitRule&, kdtree::BuildCounters&);

class PreSplit : public testing::TestWithParam<Split> {
 protected:
  static std::vector<kdtree::Reference> split(const TestMesh& mesh, const PreSplitRule& rule) {
    kdtree::BuildCounters counters;
    return GetParam()(mesh.view(), tests::face_refs(mesh), rule, counters);
  }
};

void expect_covered(const TestMesh& mesh, const std::vector<kdtree::Reference>& pieces) {
  ASSERT_TRUE(std::is_sorted(
      pieces.begin(), pieces.end(),
      [](const kdtree::Reference& a, const kdtree::Reference& b) { return a.id < b.id; }));
  tests::Random random(3);
  auto begin = pieces.begin();
  for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) {
    const auto end =
        std::find_if(begin, pieces.end(), [&](const kdtree::Reference& r) { return r.id != i; });
    const geometry::Face& f = mesh.faces[i];
    for (int k = 0; k < 30; ++k) {
      const double u = k == 0 ? 1 : random.uniform(), v = random.uniform(0, 1 - u);
      const geometry::Vec3d p = geometry::Vec3d(mesh.vertices[f[0]]) * (1 - u - v) +
                                geometry::Vec3d(mesh.vertices[f[1]]) * u +
                                geometry::Vec3d(mesh.vertices[f[2]]) * v;
      ASSERT_TRUE(std::any_of(begin, end,
                              [&](const kdtree::Reference& r) {
                                for (std::size_t a = 0; a < 3; ++a) {
                                  const double off = 1e-14 * std::fabs(p[a]);
                                  if (p[a] < static_cast<double>(r.lo[a]) - off ||
                                      p[a] > static_cast<double>(r.hi[a]) + off)
                                    return false;
                                }
                                return true;
                              }))
          << "face " << i;
    }
    begin = end;
  }
  EXPECT_TRUE(begin == pieces.end());
}

TEST(PreSplitRule, NamesTheValueOutOfRange) {
  EXPECT_FALSE(PreSplitRule{}.check());
  EXPECT_NE(PreSplitRule{.threshold = 2}.check().value_or("").find("threshold"), std::string::npos);
  EXPECT_NE(PreSplitRule{.budget = 65}.check().value_or("").find("64"), std::string::npos);
  EXPECT_TRUE(PreSplitRule{.threshold = std::nan("")}.check());
}

TEST_P(PreSplit, PiecesCoverTheirTriangles) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const TestMesh mesh = tests::random_soup(200, 0.5, seed);
    expect_covered(mesh, split(mesh, {.threshold = 1e-3}));
    expect_covered(mesh, split(mesh, {.budget = 9.5}));
  }
  TestMesh far = tests::random_soup(100, 0.5, 7);
  for (geometry::Vec3f& v : far.vertices) v = v + geometry::Vec3f{1e6f, -3e5f, 10};
  expect_covered(far, split(far, {.budget = 20}));
}

TEST_P(PreSplit, UsesTheBudgetExactly) {
  const TestMesh mesh = tests::turned(tests::beams(3), 45);
  for (const double budget : {1.0, 1.25, 2.0, 7.0}) {
    const auto most = static_cast<std::size_t>(budget * static_cast<double>(mesh.faces.size()));
    EXPECT_EQ(split(mesh, {.budget = budget}).size(), most);
  }
  EXPECT_EQ(split(mesh, {.budget = 0.5}).size(), mesh.faces.size());
}

TEST_P(PreSplit, AThresholdOfTheWholeRootSplitsNothing) {
  const TestMesh mesh = tests::random_soup(100, 0.5, 2);
  const std::vector<kdtree::Reference> refs = tests::face_refs(mesh),
                                       pieces = split(mesh, {.threshold = 1});
  ASSERT_EQ(pieces.size(), refs.size());
  for (std::size_t i = 0; i < refs.size(); ++i) EXPECT_EQ(pieces[i].bounds(), refs[i].bounds());
}

TEST_P(PreSplit, NoThresholdIsTooSmall) {
  for (const float scale : {1e-38f, 1.0f, 1e30f}) {
    TestMesh mesh = tests::random_soup(10, 0.5, 4);
    for (geometry::Vec3f& v : mesh.vertices) v = v * scale;
    const std::vector<kdtree::Reference> pieces = split(mesh, {.threshold = 0});
    EXPECT_LE(pieces.size(), 640u);
    expect_covered(mesh, pieces);
  }
}

TEST_P(PreSplit, EmptyMeshesAndPointsDoNotChange) {
  EXPECT_TRUE(split({}, {.budget = 4}).empty());
  const TestMesh points{{{1, 2, 3}}, {{0, 0, 0}, {0, 0, 0}}};
  EXPECT_EQ(split(points, {.threshold = 0}).size(), 2u);
  EXPECT_EQ(split(points, {.budget = 64}).size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Methods, PreSplit, testing::Values(&split_early, &split_edges),
                         [](const auto& method) {
                           return method.param == &split_early ? "Early" : "Edges";
                         });

TEST(EarlySplit, NoPieceIsLargerThanTheThreshold) {
  const TestMesh mesh = tests::random_soup(50, 0.5, 5);
  const std::vector<kdtree::Reference> refs = tests::face_refs(mesh);
  kdtree::BuildCounters counters;
  const std::vector<kdtree::Reference> pieces =
      split_early(mesh.view(), refs, {.threshold = 0.02}, counters);
  const double most = 0.02 * half_area(bounds_of(refs));
  EXPECT_GT(pieces.size(), refs.size());
  for (const kdtree::Reference& piece : pieces) EXPECT_LE(half_area(piece.bounds()), most);
  EXPECT_EQ(counters.touches_prepare, 2 * (pieces.size() - refs.size()));
}

TEST(EdgeSplit, KeepsAxisAlignedTrianglesWhole) {
  const TestMesh mesh = tests::beams(3);
  kdtree::BuildCounters counters;
  EXPECT_EQ(split_edges(mesh.view(), tests::face_refs(mesh), {.threshold = 0}, counters).size(),
            mesh.faces.size());
}

}  // namespace
}  // namespace sightline::accel::published::bvh
