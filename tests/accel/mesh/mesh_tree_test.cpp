// Lazy, full and scanned trees give the same hits, for every builder and kind of input.
#include "accel/mesh/mesh_tree.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/published/any_builder.h"
#include "accel/published/bvh/bvh_tree.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/published/bvh/check_hierarchy.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

using tests::TestMesh;

struct Answer {
  double t = geometry::kInfinity;
  std::uint32_t primitive = 0;
  bool operator==(const Answer&) const = default;
};

std::unique_ptr<MeshTree> make_tree(
    const TestMesh& mesh, const published::AnyBuilder& builder = published::default_builder(),
    References references = References::kRuns) {
  return std::make_unique<MeshTree>(mesh.view(), compute_mesh_stats(mesh.view()), builder,
                                    references);
}

MeshQuery query_of(const geometry::Ray& ray) {
  MeshQuery query;
  query.ray = *make_local_ray(ray.origin, ray.direction);
  query.tmin = ray.tmin;
  query.tmax = ray.tmax;
  query.node = 1;
  return query;
}

Answer ask(MeshTree& tree, const geometry::Ray& ray, OnDeferred on_deferred = OnDeferred::kExpand) {
  const kdtree::EpochPin pin;
  MeshQuery query = query_of(ray);
  query.on_deferred = on_deferred;
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;
  tree.query(query, walked, built);
  return query.found ? Answer{query.best_t, query.best_primitive} : Answer{};
}

/// The hit rule over every triangle, without a tree. (The independent oracle is in tests/e2e.)
Answer search(const TestMesh& mesh, const geometry::Ray& ray) {
  const geometry::LocalRay local = *make_local_ray(ray.origin, ray.direction);
  Answer best;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (!face_bounds(mesh.view(), i)) continue;
    const geometry::Face& f = mesh.faces[i];
    const auto t = intersect(local, mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]);
    if (!t) continue;
    const double world = *t * local.unit;
    if (world >= ray.tmin && world <= ray.tmax && world < best.t)
      best = {world, static_cast<std::uint32_t>(i)};
  }
  return best;
}

std::vector<geometry::Aabb> reference_bounds(const TestMesh& mesh) {
  std::vector<geometry::Aabb> bounds;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    bounds.push_back(face_bounds(mesh.view(), i).value_or(geometry::Aabb{}));
  return bounds;
}

struct Case {
  std::string name;
  std::function<TestMesh()> make;
};

/// One face with a NaN vertex, one that is no triangle, some without area.
TestMesh damaged() {
  TestMesh mesh = tests::icosphere(2);
  mesh.vertices.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  mesh.vertices.push_back({0, std::numeric_limits<float>::infinity(), 0});
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.faces.push_back({0, 1, n - 1});
  mesh.faces.push_back({0, 1, n - 2});
  mesh.faces.push_back({geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex});
  mesh.faces.push_back({3, 3, 3});
  mesh.faces.push_back({3, 4, 3});
  return mesh;
}

/// Flat triangles in one plane, among others that leave it by a single float.
TestMesh thin() {
  TestMesh mesh = tests::planar_sheet(6);
  const float above = geometry::least_above(1), below = std::nextafter(1.0f, 0.0f);
  for (geometry::Vec3f& v : mesh.vertices) v.z = 1;
  tests::Random random(4);
  for (int i = 0; i < 60; ++i) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) {
      const auto x = [&] { return static_cast<float>(random.below(13)) / 2; };
      mesh.vertices.push_back({x(), x(), random.below(2) == 0 ? 1.0f : i % 2 == 0 ? above : below});
    }
    mesh.faces.push_back({n, n + 1, n + 2});
  }
  mesh.append(tests::box({2, 2, 1}, {4, 4, 3}));
  return mesh;
}

/// Corners on a lattice: many flat triangles, and planes through corners of other triangles.
TestMesh lattice() {
  TestMesh mesh;
  tests::Random random(5);
  for (std::uint32_t i = 0; i < 300; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto x = [&] { return static_cast<float>(random.below(6)); };
      mesh.vertices.push_back({x(), x(), x()});
    }
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

std::vector<Case> cases() {
  std::vector<Case> all{
      {"triangle", tests::single_triangle},
      {"cube", [] { return tests::cube(); }},
      {"staircase", [] { return tests::staircase(40); }},
      {"sheet", [] { return tests::planar_sheet(20); }},
      {"walls", [] { return tests::flat_walls(50); }},
      {"duplicates", [] { return tests::duplicates(300); }},
      {"fan", [] { return tests::fan(256); }},
      {"soup", [] { return tests::random_soup(2000, 0.05, 1); }},
      {"large_soup", [] { return tests::random_soup(300, 0.8, 2); }},
      {"sphere", [] { return tests::icosphere(4); }},
      {"thin", thin},
      {"lattice", lattice},
      {"damaged", damaged},
      {"empty", [] { return TestMesh{}; }},
  };
  for (std::uint32_t n = 2; n <= 40; ++n) {
    all.push_back({"soup_of_" + std::to_string(n), [n] { return tests::random_soup(n, 0.3, n); }});
  }
  return all;
}

/// Random rays, and rays that meet vertices, edges, planes and grid lines exactly.
std::vector<geometry::Ray> rays_for(const TestMesh& mesh, std::size_t count) {
  if (mesh.faces.empty()) return {geometry::Ray{{0, 0, 0}, {1, 0, 0}}};
  std::vector<geometry::Ray> rays = tests::rays_at(mesh, count, 99);
  tests::Random random(5);
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Vec3d v(mesh.vertices[random.below(mesh.vertices.size())]);
    const geometry::Vec3d w(mesh.vertices[random.below(mesh.vertices.size())]);
    if (!is_finite(v) || !is_finite(w)) continue;
    rays.push_back({v - geometry::Vec3d{0, 0, 5}, {0, 0, 1}});
    rays.push_back({v + geometry::Vec3d{5, 0, 0}, {-1, -0.0, 0}});
    rays.push_back(
        {v, {0, 1, 0}});  // Starts on the surface, often on a split plane, along a grid line
    rays.push_back({w, {1, 1, 0}, -3, 3});
    const geometry::Vec3d from = v + random.direction() * 3.0;
    rays.push_back({from, v - from, 0.25, 1});  // Ends on the vertex: both limits are closed
    rays.push_back({from, (v + w) * 0.5 - from});
  }
  // For a mesh with a vertex at infinity, some of the rays are invalid.
  std::erase_if(
      rays, [](const geometry::Ray& ray) { return !make_local_ray(ray.origin, ray.direction); });
  return rays;
}

void check(const MeshTree& tree, const TestMesh& mesh, const published::AnyBuilder& builder) {
  const kdtree::EpochPin pin;
  if (tree.whole() != nullptr) {
    const auto& hierarchy = dynamic_cast<const published::bvh::BvhTree&>(*tree.whole());
    if (hierarchy.is_built()) tests::check_hierarchy(*hierarchy.built(), mesh);
    return;
  }
  const published::KdBuilder& kd = std::get<published::KdBuilder>(builder);
  const bool may_clip = published::rule_of(kd)->clips(1000, 1000);
  if (may_clip || std::holds_alternative<published::kd::ExactBuilder>(kd)) {
    tests::check_closed_tree(*tree.kd(), mesh, reference_bounds(mesh));
  } else {
    tests::check_tree(*tree.kd(), mesh, reference_bounds(mesh));
  }
}

/// The naive search takes quadratic time.
bool takes_too_long(std::string_view builder, const TestMesh& mesh) {
  return builder == "sah-naive" && mesh.faces.size() > 1000;
}

class EveryShape : public ::testing::TestWithParam<Case> {};

TEST_P(EveryShape, LazyFullAndSearchedTreesAnswerAlike) {
  const TestMesh mesh = GetParam().make();
  const std::vector<geometry::Ray> rays = rays_for(mesh, 60);
  for (const std::string_view name : published::builder_names()) {
    if (takes_too_long(name, mesh)) continue;
    const published::AnyBuilder builder = *published::make_builder(name);
    const auto lazy = make_tree(mesh, builder), full = make_tree(mesh, builder),
               deferred = make_tree(mesh, builder);
    kdtree::BuildCounters counters;
    full->expand_all(counters);
    {
      const kdtree::EpochPin pin;
      const kdtree::TreeMetrics m = full->metrics();
      EXPECT_EQ(m.deferred_cells, m.failed_cells);
    }
    check(*full, mesh, builder);
    for (const geometry::Ray& ray : rays) {
      const Answer expected = search(mesh, ray);
      ASSERT_EQ(ask(*lazy, ray), expected) << name;
      ASSERT_EQ(ask(*full, ray), expected) << name;
      ASSERT_EQ(ask(*deferred, ray, OnDeferred::kScan), expected) << name;
      ASSERT_EQ(ask(*lazy, ray, OnDeferred::kScan), expected) << name;
    }
    EXPECT_TRUE(mesh.faces.empty() || deferred->untouched());
    check(*lazy, mesh, builder);
  }
}

TEST_P(EveryShape, AnAnyHitExistsIfAndOnlyIfANearestHitDoes) {
  const TestMesh mesh = GetParam().make();
  const auto tree = make_tree(mesh);
  for (const geometry::Ray& ray : rays_for(mesh, 40)) {
    const kdtree::EpochPin pin;
    MeshQuery any = query_of(ray);
    any.any = true;
    kdtree::WalkCounters walked;
    kdtree::BuildCounters built;
    tree->query(any, walked, built);
    ASSERT_EQ(any.found, search(mesh, ray).t < geometry::kInfinity);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape, ::testing::ValuesIn(cases()),
                         [](const auto& shape) { return shape.param.name; });

TEST(MeshTree, GrowsOnlyWhereRaysGo) {
  const TestMesh mesh = tests::icosphere(5);  // 20,480 triangles
  const auto tree = make_tree(mesh);
  kdtree::WalkCounters walked;
  kdtree::BuildCounters first, again;
  std::vector<geometry::Ray> rays;
  tests::Random random(2);
  for (int i = 0; i < 500; ++i) {
    rays.push_back({{0, 0, 3},
                    geometry::Vec3d{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), -1},
                    0,
                    2.5});
  }
  const kdtree::EpochPin pin;
  for (const geometry::Ray& ray : rays) {
    MeshQuery query = query_of(ray);
    tree->query(query, walked, first);
  }
  EXPECT_GT(first.cells_expanded, 0u);
  EXPECT_GE(first.touches_prepare, mesh.faces.size());
  EXPECT_LT(first.touches_prepare, 2 * mesh.faces.size());
  const kdtree::GrowthMetrics growth = tree->growth();
  EXPECT_GT(growth.references_built, 0u);
  EXPECT_LT(growth.references_built, mesh.faces.size() / 5);
  for (const geometry::Ray& ray : rays) {
    MeshQuery query = query_of(ray);
    tree->query(query, walked, again);
  }
  EXPECT_EQ(again.cells_expanded, 0u);
  EXPECT_EQ(again.touches, 0u);
}

/// A tree that is built at once, and one that rays begin.
struct FullAndLazy {
  explicit FullAndLazy(bool blocks) {
    split::ScanSplit rule = split::scan_fast();
    rule.blocks = blocks;
    full = make_tree(mesh, published::KdBuilder(rule));
    lazy = make_tree(mesh, published::KdBuilder(rule));
    kdtree::BuildCounters counters;
    full->expand_all(counters);
    for (const geometry::Ray& ray : rays) ask(*lazy, ray);
    lazy->expand_all(counters);
  }

  const TestMesh mesh = tests::random_soup(5000, 0.03, 3);
  const std::vector<geometry::Ray> rays = tests::rays_at(mesh, 50, 1);
  std::unique_ptr<MeshTree> full, lazy;
};

TEST(MeshTree, AFinishedLazyTreeEqualsTheFullTree) {
  const FullAndLazy trees(false);
  const kdtree::EpochPin pin;
  const kdtree::TreeMetrics a = trees.full->metrics(), b = trees.lazy->metrics();
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.references, b.references);
  EXPECT_EQ(a.max_depth, b.max_depth);
  EXPECT_DOUBLE_EQ(a.sah_cost, b.sah_cost);
  EXPECT_EQ(b.deferred_cells, 0u);
}

// The cells are the same; which of them share wide nodes depends on what was built at once.
TEST(MeshTree, AFinishedLazyTreeHasTheBlocksOfTheFullTree) {
  const FullAndLazy trees(true);
  for (const geometry::Ray& ray : trees.rays)
    EXPECT_EQ(ask(*trees.full, ray), ask(*trees.lazy, ray));
  const kdtree::EpochPin pin;
  const kdtree::TreeMetrics a = trees.full->metrics(), b = trees.lazy->metrics();
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.references, b.references);
  EXPECT_NEAR(a.expected_intersections, b.expected_intersections, 0.01 * a.expected_intersections);
  EXPECT_EQ(b.deferred_cells, 0u);
}

TEST(MeshTree, TreesStayUsableAfterACancelledBuild) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 4);
  const auto tree = make_tree(mesh);
  const std::atomic<bool> cancelled{true};
  kdtree::BuildCounters counters;
  tree->expand_all(counters, &cancelled);
  {
    const kdtree::EpochPin pin;
    EXPECT_GT(tree->metrics().deferred_cells, 0u);
  }
  for (const geometry::Ray& ray : tests::rays_at(mesh, 20, 1))
    EXPECT_EQ(ask(*tree, ray), search(mesh, ray));
  tree->expand_all(counters);
  const kdtree::EpochPin pin;
  EXPECT_EQ(tree->metrics().deferred_cells, 0u);
}

/// How many triangles a cancelled ray tests that has `tree` searched.
std::uint64_t tests_when_cancelled(MeshTree& tree, const geometry::LocalRay& ray) {
  const kdtree::EpochPin pin;
  const std::atomic<bool> cancelled{true};
  MeshQuery query;
  query.on_deferred = OnDeferred::kScan;
  query.cancelled = &cancelled;
  query.ray = ray;
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;
  tree.query(query, walked, built);
  return walked.tests;
}

TEST(MeshTree, ACancelledRayLeavesALongSearch) {
  // All triangles meet the ray, and none hides another.
  TestMesh mesh;
  constexpr std::uint32_t kTriangles = 50'000;
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    const float z = static_cast<float>(kTriangles - i);
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto tree = make_tree(mesh);
  const auto ray = geometry::make_local_ray({0.2, 0.2, -1}, {0, 0, 1});
  EXPECT_LE(tests_when_cancelled(*tree, *ray), lazy::kSearchStep) << "before the root has a list";
  // A ray across the first one expands some cells.
  ask(*tree, {.origin = {-1, 0.2, 25000.5}, .direction = {1, 0, 0}});
  EXPECT_LE(tests_when_cancelled(*tree, *ray), lazy::kSearchStep);
}

TEST(MeshTree, ThreadsInOneColdTreeAgree) {
  // Large enough that the first cells are shared by threads and the later ones are raced for.
  const TestMesh mesh = tests::random_soup(60000, 0.01, 6);
  const std::vector<geometry::Ray> rays = tests::rays_at(mesh, 1500, 8);
  const auto reference = make_tree(mesh);
  kdtree::BuildCounters counters;
  reference->expand_all(counters);
  std::vector<Answer> expected;
  for (const geometry::Ray& ray : rays) expected.push_back(ask(*reference, ray));
  const auto tree = make_tree(mesh);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      if (i == 7) {
        kdtree::BuildCounters own;
        tree->expand_all(own);
        return;
      }
      for (std::size_t k = 0; k < rays.size(); ++k) {
        const std::size_t at = (k + static_cast<std::size_t>(i) * 37) % rays.size();
        if (ask(*tree, rays[at]) != expected[at]) ++wrong;
      }
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
  const kdtree::EpochPin pin;
  EXPECT_EQ(tree->metrics().deferred_cells, 0u);
}

}  // namespace
}  // namespace sightline::accel::mesh
