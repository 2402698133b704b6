// Trees from sorted events, and cell by cell by the naive and the sorted search, are equal.
#include "accel/published/kd/event_growth.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "accel/mesh/mesh_stats.h"
#include "accel/published/any_builder.h"
#include "accel/published/kd/plain_tree.h"
#include "tests/accel/published/kd/check_plain_tree.h"
#include "tests/accel/published/kd/cuts.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::kd {
namespace {

using tests::TestMesh;

void expect_same(const PlainCells& a, PlainNode at, const PlainCells& b, PlainNode other) {
  ASSERT_EQ(at.is_leaf(), other.is_leaf());
  ASSERT_EQ(at.is_failed(), other.is_failed());
  if (at.is_leaf()) {
    ASSERT_EQ(tests::ids_of(a, at), tests::ids_of(b, other));
    return;
  }
  ASSERT_EQ(at.axis(), other.axis());
  ASSERT_EQ(at.position(), other.position());
  for (std::size_t i = 0; i < 2; ++i)
    expect_same(a, a.pairs.at(at.pair())[i], b, b.pairs.at(other.pair())[i]);
}

void expect_same(const PlainTree& a, const PlainTree& b) {
  ASSERT_EQ(a.cells(), b.cells());
  expect_same(*a.built(), a.built()->root, *b.built(), b.built()->root);
}

/// A built tree. The mesh must outlive it.
struct BuiltTree {
  BuiltTree(const TestMesh& mesh, const ExactBuilder& builder, int threads = 1)
      : tree(mesh.view(), mesh::compute_mesh_stats(mesh.view()), plain_rule(builder)) {
    tbb::task_arena(threads).execute([&] { tree.build(counters); });
  }
  kdtree::BuildCounters counters;
  PlainTree tree;
};

/// Triangles with corners on a lattice: many flat ones, many equal bounds.
TestMesh lattice_soup(std::uint32_t n, std::uint64_t seed) {
  tests::Random random(seed);
  TestMesh mesh;
  for (std::uint32_t i = 0; i < 3 * n; ++i) {
    const auto x = [&] { return static_cast<float>(random.below(5)); };
    mesh.vertices.push_back({x(), x(), x()});
  }
  for (std::uint32_t i = 0; i < n; ++i) mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return mesh;
}

TestMesh furnished_mesh() {
  TestMesh mesh = tests::planar_sheet(6);
  for (std::uint32_t i = 0; i < 7; ++i) {
    const auto x = static_cast<float>(i);
    mesh.append(tests::box({x, 0, 0}, {x, 6, 3}));
    mesh.append(tests::box({0, x, 0}, {6, x, 3}));
  }
  return mesh;
}

struct Case {
  std::string name;
  std::function<TestMesh()> make;
};

std::vector<Case> cases() {
  return {
      {"cube", [] { return tests::cube(); }},
      {"staircase", [] { return tests::staircase(12); }},
      {"sheet", [] { return tests::planar_sheet(9); }},
      {"walls", [] { return tests::flat_walls(30); }},
      {"duplicates", [] { return tests::duplicates(40); }},
      {"fan", [] { return tests::fan(32); }},
      {"room", furnished_mesh},
      {"soup", [] { return tests::random_soup(300, 0.1, 1); }},
      {"large_soup", [] { return tests::random_soup(60, 0.8, 2); }},
      {"lattice", [] { return lattice_soup(150, 3); }},
      {"sphere", [] { return tests::icosphere(2); }},
  };
}

class EveryScene : public ::testing::TestWithParam<Case> {};

TEST_P(EveryScene, ThreeSearchesBuildTheSameTree) {
  const TestMesh mesh = GetParam().make();
  for (const auto& [clip, lambda, bad_refines] :
       {std::tuple(true, 0.8, 0u), {true, 1.0, 0u}, {false, 0.8, 0u}, {true, 0.8, 1u}}) {
    ExactBuilder builder{.costs = {.lambda = lambda}, .bad_refines = bad_refines, .clip = clip};
    builder.search = ExactSearch::kSweep;
    const BuiltTree swept(mesh, builder);
    for (const ExactSearch search : {ExactSearch::kNaive, ExactSearch::kSort}) {
      builder.search = search;
      expect_same(swept.tree, BuiltTree(mesh, builder).tree);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, ::testing::ValuesIn(cases()),
                         [](const auto& scene) { return scene.param.name; });

TEST(ExactTrees, SortAndSweepBuildTheSameLargeTree) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 5);
  const BuiltTree sorted(mesh, {.search = ExactSearch::kSort}), swept(mesh, {});
  expect_same(sorted.tree, swept.tree);
  EXPECT_GT(swept.tree.cells(), mesh.faces.size());
}

TEST(ExactTrees, ThreadsBuildTheSameTree) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 6);
  const BuiltTree alone(mesh, {}), together(mesh, {}, 4);
  expect_same(alone.tree, together.tree);
  EXPECT_EQ(alone.counters.touches, together.counters.touches);
}

std::vector<kdtree::Reference> failed(const BuiltTree& built) {
  std::vector<kdtree::Reference> refs = built.tree.built()->failed;
  std::ranges::sort(refs, {}, [](const kdtree::Reference& ref) {
    return std::tuple(ref.id, ref.lo.x, ref.lo.y, ref.lo.z);
  });
  return refs;
}

TEST(ExactTrees, SortAndSweepFailInTheSameCells) {
  const TestMesh mesh = tests::find_hard_mesh("fan")->make(3000, 7);
  const BuiltTree sorted(mesh, {.search = ExactSearch::kSort}), swept(mesh, {});
  expect_same(sorted.tree, swept.tree);
  const std::vector<kdtree::Reference> a = failed(sorted), b = failed(swept);
  ASSERT_GT(a.size(), 0u);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].id, b[i].id);
    ASSERT_EQ(a[i].bounds(), b[i].bounds());
  }
}

}  // namespace
}  // namespace sightline::accel::published::kd
