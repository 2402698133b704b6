// Whole trees of the exact builders: naive, sorted, swept, cell by cell and on many threads are all
// equal.
#include "accel/published/kd/event_growth.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "accel/grow/grow.h"
#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "accel/split/split_search.h"
#include "tests/accel/boxes.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/published/kd/cuts.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::kd {
namespace {

using tests::bounds_of;
using tests::TestMesh;

/// The references of a leaf, or of a deferred cell that failed for lack of capacity, as a set.
std::vector<std::uint32_t> held(const kdtree::KdTree& tree, kdtree::Slot slot) {
  std::vector<std::uint32_t> ids;
  if (slot.is_deferred()) {
    ids = tests::ids_of(slot.cell()->list);
  } else if (slot.leaf_count() > 0) {
    std::uint32_t storage;
    const auto leaf = tree.leaf(slot, storage);
    ids.assign(leaf.begin(), leaf.end());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

void expect_same(const kdtree::KdTree& a, kdtree::Slot at, const kdtree::KdTree& b,
                 kdtree::Slot other, std::size_t& cells) {
  ++cells;
  ASSERT_EQ(at.tag(), other.tag());
  if (at.is_binary()) {
    ASSERT_EQ(at.position(), other.position());
    for (std::size_t i = 0; i < 2; ++i)
      expect_same(a, kdtree::load(a.children(at)[i]), b, kdtree::load(b.children(other)[i]), cells);
    return;
  }
  ASSERT_EQ(held(a, at), held(b, other));
}

std::size_t expect_same(const kdtree::KdTree& a, const kdtree::KdTree& b) {
  std::size_t cells = 0;
  expect_same(a, kdtree::load(a.root()), b, kdtree::load(b.root()), cells);
  return cells;
}

lazy::ReferenceSource source_of_faces(const geometry::MeshView& mesh) {
  lazy::ReferenceSource source;
  source.coarsest = [mesh](kdtree::BuildCounters&) {
    return lazy::ReferenceSource::Coarsest{.slots = mesh.faces.size()};
  };
  source.list = [mesh](std::size_t begin, std::size_t end, kdtree::Reference* out,
                       kdtree::BuildCounters&) {
    return mesh::face_references(mesh, begin, end, out);
  };
  return source;
}

std::unique_ptr<lazy::LazyTree> make_tree(const TestMesh& mesh, const geometry::MeshView& view,
                                          const ExactBuilder& builder) {
  const mesh::MeshStats survey = mesh::compute_mesh_stats(mesh.view());
  return std::make_unique<lazy::LazyTree>(padded(survey.bounds), survey.finite_triangles,
                                          rule_of(builder), source_of_faces(view), &view);
}

void touch_all(lazy::LazyTree& tree, kdtree::AtomicSlot& slot) {
  kdtree::BuildCounters counters;
  while (kdtree::load(slot).is_deferred() &&
         tree.expand(slot, lazy::WhenPending::kWait, counters) == lazy::ExpandResult::kRetry) {
  }
  if (!kdtree::load(slot).is_binary()) return;
  kdtree::AtomicSlot* children = tree.tree().children(kdtree::load(slot));
  touch_all(tree, children[0]);
  touch_all(tree, children[1]);
}

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
  const geometry::MeshView view = mesh.view();
  for (const auto& [clip, lambda, bad_refines] :
       {std::tuple(true, 0.8, 0u), {true, 1.0, 0u}, {false, 0.8, 0u}, {true, 0.8, 1u}}) {
    ExactBuilder builder{.costs = {.lambda = lambda}, .bad_refines = bad_refines, .clip = clip};
    std::vector<std::unique_ptr<lazy::LazyTree>> trees;
    for (const ExactSearch search : tests::kExactSearches) {
      builder.search = search;
      trees.push_back(make_tree(mesh, view, builder));
      kdtree::BuildCounters counters;
      trees.back()->expand_all(counters);
    }
    trees.push_back(make_tree(mesh, view, builder));  // Cell by cell
    const kdtree::EpochPin pin;
    touch_all(*trees.back(), trees.back()->root());
    for (std::size_t i = 1; i < trees.size(); ++i) {
      const kdtree::TreeMetrics m = measure(trees[0]->tree());
      EXPECT_EQ(expect_same(trees[0]->tree(), trees[i]->tree()), m.nodes + m.deferred_cells);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, ::testing::ValuesIn(cases()),
                         [](const auto& scene) { return scene.param.name; });

TEST(ExactTrees, SortAndSweepBuildTheSameLargeTree) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 5);
  const geometry::MeshView view = mesh.view();
  std::vector<std::unique_ptr<lazy::LazyTree>> trees;
  for (const ExactSearch search : {ExactSearch::kSort, ExactSearch::kSweep}) {
    trees.push_back(make_tree(mesh, view, {.search = search}));
    kdtree::BuildCounters counters;
    trees.back()->expand_all(counters);
  }
  const kdtree::EpochPin pin;
  EXPECT_GT(expect_same(trees[0]->tree(), trees[1]->tree()), mesh.faces.size());
}

TEST(ExactTrees, ThreadsBuildTheSameTree) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 6);
  const geometry::MeshView view = mesh.view();
  std::vector<std::unique_ptr<lazy::LazyTree>> trees;
  std::vector<std::uint64_t> touches;
  for (const int threads : {1, 4}) {
    tbb::task_arena arena(threads);
    trees.push_back(make_tree(mesh, view, {}));
    kdtree::BuildCounters counters;
    arena.execute([&] { trees.back()->expand_all(counters); });
    touches.push_back(counters.touches);
  }
  const kdtree::EpochPin pin;
  expect_same(trees[0]->tree(), trees[1]->tree());
  EXPECT_EQ(touches[0], touches[1]);
}

/// Instances of a scene: heavy references that cannot be clipped.
TEST(ExactTrees, SweepHonoursWeightsWithoutAMesh) {
  const std::vector<kdtree::Reference> refs = tests::lattice_boxes(200, 50, 8);
  std::vector<std::unique_ptr<lazy::LazyTree>> trees;
  for (const ExactSearch search : tests::kExactSearches) {
    trees.push_back(std::make_unique<lazy::LazyTree>(bounds_of(refs), refs.size(),
                                                     rule_of(ExactBuilder{.search = search}),
                                                     lazy::source_of(refs)));
    kdtree::BuildCounters counters;
    trees.back()->expand_all(counters);
  }
  const kdtree::EpochPin pin;
  expect_same(trees[0]->tree(), trees[1]->tree());
  EXPECT_GT(expect_same(trees[0]->tree(), trees[2]->tree()), 3u);
}

TEST(ExactTrees, ACancelledSweepLeavesUsableLists) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 9);
  const geometry::MeshView view = mesh.view();
  const auto whole = make_tree(mesh, view, {}), parts = make_tree(mesh, view, {});
  kdtree::BuildCounters counters;
  whole->expand_all(counters);
  const kdtree::EpochPin pin;
  // One cut by a ray, then both halves are deferred again by a cancelled sweep of each, then
  // finished.
  while (kdtree::load(parts->root()).is_deferred())
    ASSERT_EQ(parts->expand(parts->root(), lazy::WhenPending::kWait, counters),
              lazy::ExpandResult::kRetry);
  const std::atomic<bool> cancelled{true};
  const kdtree::Slot root = kdtree::load(parts->root());
  for (std::size_t i = 0; i < 2; ++i) {
    kdtree::AtomicSlot& child = parts->tree().children(root)[i];
    const kdtree::DeferredCell& cell = *kdtree::load(child).cell();
    kdtree::KdTree scratch(cell.box, cell.size);
    scratch.reserve();
    const split::SplitRule rule = rule_of(ExactBuilder{});
    const grow::GrowContext context{scratch, *rule, &view, 60, &cancelled};
    const kdtree::ReferenceList listed = cell.list.copy();
    std::vector<kdtree::Reference> list(listed.all().begin(), listed.all().end());
    const kdtree::Slot again = grow::grow(context, list, cell.box, cell.path, counters);
    ASSERT_TRUE(again.is_deferred());
    const kdtree::ReferenceList deferred = again.cell()->list.copy();
    const auto before = listed.all(), after = deferred.all();
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
      ASSERT_EQ(before[k].id, after[k].id);
      ASSERT_EQ(before[k].bounds(), after[k].bounds());
    }
    delete again.cell();
  }
  parts->expand_all(counters);
  expect_same(whole->tree(), parts->tree());
}

}  // namespace
}  // namespace sightline::accel::published::kd
