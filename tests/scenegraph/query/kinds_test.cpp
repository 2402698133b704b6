// Closest, any, count and all see the same hits, for all options.
#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "accel/published/any_builder.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Culling;
using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using tests::ask_all_kinds;
using tests::contradiction;
using tests::KindAnswers;

std::shared_ptr<const model::Mesh> mesh_with(const accel::published::AnyBuilder& builder,
                                             const tests::TestMesh& m) {
  return *model::Mesh::make(m.vertices, m.faces, builder);
}

/// Small triangles, and some large ones across all of them, which are in very many leaves.
tests::TestMesh straddled(std::uint32_t triangles, std::uint64_t seed) {
  tests::TestMesh mesh = tests::random_soup(triangles, 0.08, seed);
  mesh.append(tests::random_soup(20, 3, seed + 1));
  return mesh;
}

/// Node 1 is a group with the even nodes below it; node 2 lies under 1 and has a mesh and every
/// fourth node. Masks cycle.
std::shared_ptr<const revision::Snapshot> random_scene(
    int nodes, const accel::published::AnyBuilder& builder) {
  tests::Random random(31);
  const auto sphere = mesh_with(builder, tests::icosphere(2));
  const auto soup = mesh_with(builder, straddled(300, 5));
  Scene scene;
  std::vector<model::Update> updates{
      tests::put_node(-1, 0, nullptr, tests::random_frame(random, tests::Frames::kSheared, 1))};
  for (int id = 2; id <= nodes; ++id) {
    const model::NodeRef parent = id == 2 ? -1 : id % 4 == 0 ? -2 : id % 2 == 0 ? -1 : 0;
    model::PutNode node = tests::put_node(-id, parent, id % 3 == 0 ? sphere : soup,
                                          tests::random_frame(random, tests::Frames::kSheared, 2));
    node.mask = 1u << (id % 3);
    updates.push_back(node);
  }
  EXPECT_TRUE(scene.apply(updates));
  return scene.snapshot();
}

std::shared_ptr<const revision::Snapshot> random_scene(int nodes) {
  return random_scene(nodes, accel::published::default_builder());
}

/// Some with limits and masks of their own.
std::vector<Ray> rays_through(const revision::Snapshot& snapshot, std::size_t n,
                              std::uint64_t seed) {
  std::vector<Ray> rays = tests::rays_through(snapshot, n, seed);
  tests::Random random(seed + 1000);
  for (Ray& ray : rays) {
    if (random.below(2) == 0) {
      ray.tmin = random.uniform(-0.5, 0.5);
      ray.tmax = ray.tmin + random.uniform(0, 1);
    }
    if (random.below(3) == 0) ray.mask = static_cast<std::uint32_t>(random.below(8));
  }
  return rays;
}

/// Nodes of random_scene() that a selection hides, from the parents that random_scene() gives them.
std::vector<std::uint64_t> hidden_by(int nodes, model::NodeId root,
                                     const std::vector<model::NodeId>& excluded) {
  std::vector<std::uint64_t> hidden;
  for (int id = 1; id <= nodes; ++id) {
    std::vector<model::NodeId> chain{static_cast<model::NodeId>(id)};
    if (id > 2 && id % 4 == 0) chain.push_back(2);
    if (id > 1 && id % 2 == 0) chain.push_back(1);
    const auto has = [&](model::NodeId node) {
      return std::find(chain.begin(), chain.end(), node) != chain.end();
    };
    bool seen = root == 0 || has(root);
    for (const model::NodeId node : excluded) seen = seen && !has(node);
    if (!seen) hidden.push_back(static_cast<std::uint64_t>(id));
  }
  return hidden;
}

void expect_same(const KindAnswers& a, const KindAnswers& b) {
  ASSERT_EQ(a.lists.size(), b.lists.size());
  ASSERT_EQ(a.listed.size(), b.listed.size());
  for (std::size_t i = 0; i < a.lists.size(); ++i) {
    ASSERT_EQ(a.counts[i].count, b.counts[i].count) << i;
    ASSERT_EQ(a.lists[i].count, b.lists[i].count) << i;
    ASSERT_EQ(a.lists[i].cut_off, b.lists[i].cut_off) << i;
    ASSERT_EQ(a.any[i].state, b.any[i].state) << i;
  }
  for (std::size_t k = 0; k < a.listed.size(); ++k) {
    ASSERT_EQ(a.listed[k].t, b.listed[k].t) << k;
    ASSERT_EQ(a.listed[k].node, b.listed[k].node) << k;
    ASSERT_EQ(a.listed[k].primitive, b.listed[k].primitive) << k;
    ASSERT_EQ(a.listed[k].normal, b.listed[k].normal) << k;
  }
}

TEST(Kinds, AgreeWithEachOtherAndTheOracleForAllExclusions) {
  constexpr int kNodes = 30;
  const tests::BruteForce oracle(random_scene(kNodes));
  struct Selected {
    model::NodeId root;
    std::vector<model::NodeId> excluded;
  };
  const Selected selections[] = {{0, {}},        {1, {}},     {2, {}}, {0, {1}},
                                 {0, {2, 5, 7}}, {1, {2, 6}}, {2, {1}}};
  std::uint64_t seed = 1, hits = 0;
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
    for (const Selected& selected : selections) {
      const auto snapshot = random_scene(kNodes);
      const auto selection = query::Selection::make(snapshot, selected.root, selected.excluded);
      ASSERT_TRUE(selection);
      const std::vector<Ray> rays = rays_through(*snapshot, 300, seed++);
      TraceOptions options;
      options.culling = culling;
      options.selection = &*selection;
      const KindAnswers answers = ask_all_kinds(*snapshot, rays, options);
      ASSERT_EQ(contradiction(answers, options.max_hits), "");
      const auto compared = tests::compare_kinds(
          rays, answers, oracle, {culling, hidden_by(kNodes, selected.root, selected.excluded)});
      EXPECT_EQ(compared.mismatches, 0u) << compared.report();
      EXPECT_EQ(compared.edges, 0u) << compared.report();
      hits += compared.hits;
    }
  }
  EXPECT_GT(hits, 3000u);
}

TEST(Kinds, GiveTheSameAnswersForEveryBuilderLazyFullAndScanned) {
  const std::vector<Ray> rays = rays_through(*random_scene(20), 400, 7);
  const KindAnswers expected = ask_all_kinds(*random_scene(20), rays, {});
  EXPECT_EQ(contradiction(expected, TraceOptions{}.max_hits), "");
  for (const Growth growth : {Growth::kDemand, Growth::kFull, Growth::kNone})
    expect_same(ask_all_kinds(*random_scene(20), rays, {.growth = growth}), expected);
  for (const std::string_view name : accel::published::builder_names()) {
    const auto builder = accel::published::make_builder(name);
    ASSERT_TRUE(builder);
    SCOPED_TRACE(name);
    expect_same(ask_all_kinds(*random_scene(20, *builder), rays, {}), expected);
  }
}

TEST(Kinds, GiveTheSameAnswersForAnyBatchesOrderAndThreads) {
  const auto snapshot = random_scene(30);
  const std::vector<Ray> rays = rays_through(*snapshot, 1500, 8);
  const KindAnswers expected = ask_all_kinds(*snapshot, rays, {});
  for (const int threads : {1, 2, 8}) {
    tbb::task_arena arena(threads);
    arena.execute([&] { expect_same(ask_all_kinds(*random_scene(30), rays, {}), expected); });
  }
  const auto cold = random_scene(30);
  std::size_t end = expected.listed.size();
  for (std::size_t i = rays.size(); i-- > 0;) {
    end -= expected.lists[i].count;
    if (i % 5 != 0) continue;
    const KindAnswers one = ask_all_kinds(*cold, {&rays[i], 1}, {});
    ASSERT_EQ(one.closest[0].t, expected.closest[i].t);
    ASSERT_EQ(one.any[0].state, expected.any[i].state);
    ASSERT_EQ(one.counts[0].count, expected.counts[i].count);
    ASSERT_EQ(one.listed.size(), expected.lists[i].count);
    for (std::size_t k = 0; k < one.listed.size(); ++k)
      ASSERT_EQ(one.listed[k].primitive, expected.listed[end + k].primitive);
  }
}

TEST(Kinds, AListKeepsTheNearestHitsAndMarksTheCut) {
  const auto snapshot = random_scene(30);
  const std::vector<Ray> rays = rays_through(*snapshot, 500, 9);
  const KindAnswers whole = ask_all_kinds(*snapshot, rays, {});
  std::uint64_t cut = 0;
  for (const std::uint32_t max_hits : {1u, 2u, 3u, 7u, 40u}) {
    TraceOptions options;
    options.max_hits = max_hits;
    const KindAnswers some = ask_all_kinds(*snapshot, rays, options);
    ASSERT_EQ(contradiction(some, max_hits), "");
    std::size_t of_whole = 0, of_some = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (std::size_t k = 0; k < some.lists[i].count; ++k) {
        ASSERT_EQ(some.listed[of_some + k].t, whole.listed[of_whole + k].t);
        ASSERT_EQ(some.listed[of_some + k].primitive, whole.listed[of_whole + k].primitive);
      }
      of_some += some.lists[i].count;
      of_whole += whole.lists[i].count;
      cut += some.lists[i].cut_off;
    }
  }
  EXPECT_GT(cut, 100u);
}

TEST(Kinds, AListMayPauseBetweenBlocks) {
  const auto snapshot = random_scene(30);
  const std::vector<Ray> rays = rays_through(*snapshot, 1000, 10);
  const KindAnswers whole = ask_all_kinds(*snapshot, rays, {});
  TraceOptions options;
  options.hits_at_once = 100;
  std::vector<RayTally> tallies(rays.size());
  std::vector<Hit> hits, all;
  std::size_t answered = 0;
  int parts = 0;
  while (answered < rays.size()) {
    const auto stats = list_hits(*snapshot, std::span(rays).subspan(answered),
                                 std::span(tallies).subspan(answered), hits, options);
    ASSERT_TRUE(stats);
    ASSERT_GT(stats->rays, 0u);
    answered += stats->rays;
    all.insert(all.end(), hits.begin(), hits.end());
    ++parts;
  }
  EXPECT_GT(parts, 1);
  ASSERT_EQ(all.size(), whole.listed.size());
  for (std::size_t k = 0; k < all.size(); ++k) ASSERT_EQ(all[k].t, whole.listed[k].t);
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(tallies[i].count, whole.lists[i].count);
}

TEST(Kinds, CoincidentTrianglesAreSeparateHits) {
  const auto mesh = tests::mesh_of(tests::duplicates(300));
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, mesh), tests::put_node(-2, 0, mesh)}));
  const Ray ray{{0.2, 0.2, 1}, {0, 0, -1}};
  TraceOptions options;
  options.max_hits = 1000;
  const KindAnswers answers = ask_all_kinds(*scene.snapshot(), {&ray, 1}, options);
  EXPECT_EQ(contradiction(answers, options.max_hits), "");
  ASSERT_EQ(answers.counts[0].count, 600u);
  for (std::size_t k = 0; k < 600; ++k) {
    EXPECT_EQ(answers.listed[k].node, k < 300 ? 1u : 2u);
    EXPECT_EQ(answers.listed[k].primitive, k % 300);
  }
}

// Walls in no order, so that scanning a list meets far ones first.
tests::TestMesh shuffled_walls(std::uint32_t count) {
  tests::TestMesh walls = tests::flat_walls(count);
  tests::Random random(15);
  for (std::size_t i = walls.faces.size(); i > 1; --i)
    std::swap(walls.faces[i - 1], walls.faces[random.below(i)]);
  return walls;
}

TEST(Kinds, OneRayMayHaveThousandsOfHits) {
  const auto mesh = tests::mesh_of(shuffled_walls(5000));
  const Ray ray{{-0.5, 0.3, 0.6}, {1, 0, 0}};
  for (const Growth growth : {Growth::kNone, Growth::kDemand, Growth::kFirstTouch, Growth::kFull}) {
    for (const std::uint32_t max_hits : {10u, 100u, 1000u, 4999u, 5000u, 5001u}) {
      Scene scene;
      ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, mesh)}));
      TraceOptions options;
      options.growth = growth;
      options.max_hits = max_hits;
      const KindAnswers answers = ask_all_kinds(*scene.snapshot(), {&ray, 1}, options);
      EXPECT_EQ(contradiction(answers, max_hits), "");
      EXPECT_EQ(answers.counts[0].count, 5000u);
      ASSERT_EQ(answers.listed.size(), std::min(max_hits, 5000u));
      EXPECT_EQ(answers.lists[0].cut_off, max_hits < 5000);
      for (std::size_t k = 0; k < answers.listed.size(); ++k)
        ASSERT_EQ(answers.listed[k].t, 0.5 + static_cast<double>(k));
    }
  }
}

TEST(Kinds, CullingUsesTheWindingInTheMeshsFrame) {
  const model::Affine mirror{{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  for (const model::Affine& where : {model::Affine{}, mirror}) {
    Scene scene;
    ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::cube()), where)}));
    const Ray ray{{0.25, 0.125, 5}, {0, 0, -2}};
    const auto ask = [&](Culling culling) {
      TraceOptions options;
      options.culling = culling;
      const KindAnswers answers = ask_all_kinds(*scene.snapshot(), {&ray, 1}, options);
      EXPECT_EQ(contradiction(answers, options.max_hits), "");
      return answers.closest[0];
    };
    EXPECT_EQ(ask(Culling::kNone).normal, (accel::geometry::Vec3f{0, 0, 1}));
    EXPECT_EQ(ask(Culling::kBack).t, 2);
    EXPECT_EQ(ask(Culling::kFront).t, 3);
  }
}

TEST(Kinds, EveryHitIsAFrontOrABack) {
  const auto snapshot = random_scene(30);
  const std::vector<Ray> rays = rays_through(*snapshot, 1000, 11);
  const auto counts = [&](Culling culling) {
    TraceOptions options;
    options.culling = culling;
    std::vector<RayTally> tallies(rays.size());
    EXPECT_TRUE(count_hits(*snapshot, rays, tallies, options));
    return tallies;
  };
  const auto all = counts(Culling::kNone), fronts = counts(Culling::kBack),
             backs = counts(Culling::kFront);
  for (std::size_t i = 0; i < rays.size(); ++i)
    ASSERT_EQ(all[i].count, fronts[i].count + backs[i].count) << i;
}

TEST(Kinds, AnOddCountMeansInside) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::icosphere(4)))}));
  tests::Random random(12);
  std::vector<Ray> rays;
  for (int i = 0; i < 4000; ++i) {
    const double radius = i % 2 == 0 ? random.uniform(0, 0.98) : random.uniform(1.001, 3);
    rays.push_back({random.direction() * radius, random.direction()});
    // Along the axes, where rays meet vertices and edges.
    if (i % 4 < 2) rays.back().direction = {0, i % 8 < 4 ? 1.0 : -1.0, 0};
  }
  rays.push_back({{0, 0, 0}, {0, 0, 1}});
  rays.push_back({{0, 0, 0}, {1, 0, 0}});
  std::vector<RayTally> tallies(rays.size());
  ASSERT_TRUE(count_hits(*scene.snapshot(), rays, tallies, {}));
  for (std::size_t i = 0; i < rays.size(); ++i)
    ASSERT_EQ(tallies[i].count % 2, i % 2 == 0 || i >= 4000 ? 1u : 0u) << i;
}

TEST(Kinds, ABadRayIsMarkedInEveryKind) {
  const auto snapshot = random_scene(5);
  std::vector<Ray> rays(3, Ray{{0, 0, 0}, {1, 0, 0}});
  rays[1].direction = {0, 0, 0};
  rays[2].tmax = std::numeric_limits<double>::quiet_NaN();
  const KindAnswers answers = ask_all_kinds(*snapshot, rays, {});
  EXPECT_EQ(contradiction(answers, TraceOptions{}.max_hits), "");
  for (const std::size_t i : {1u, 2u}) {
    EXPECT_EQ(answers.counts[i].count, kInvalidCount);
    EXPECT_EQ(answers.lists[i].state, HitState::kInvalid);
    EXPECT_EQ(answers.lists[i].count, 0u);
  }
}

TEST(Kinds, InvalidQueriesAreRefused) {
  const auto snapshot = random_scene(3);
  const std::vector<Ray> rays(4);
  std::vector<RayTally> tallies(3);
  std::vector<Hit> hits(4);
  EXPECT_FALSE(count_hits(*snapshot, rays, tallies, {}));
  EXPECT_FALSE(list_hits(*snapshot, rays, tallies, hits, {}));
  TraceOptions options;
  options.kind = QueryKind::kCount;
  EXPECT_EQ(trace(*snapshot, rays, hits, options).error().code, Code::kInvalidArgument);
  const std::atomic<bool> cancelled{true};
  options.cancelled = &cancelled;
  tallies.resize(4);
  EXPECT_EQ(count_hits(*snapshot, rays, tallies, options).error().code, Code::kCancelled);
  EXPECT_EQ(list_hits(*snapshot, rays, tallies, hits, options).error().code, Code::kCancelled);
}

}  // namespace
}  // namespace sightline::scenegraph::query
