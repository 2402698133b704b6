// Nodes whose transforms have no usable inverse for rays: they are part of the scene, and neither
// they nor what is below them is hit.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scenegraph/query/shard_cut.h"
#include "scenegraph/revision/deferred_cells.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/expect_oracle.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using tests::Frames;
using tests::put_node;
using tests::Random;

constexpr model::Affine kNothing{{}};

/// Scaled to nothing, to a line or to a plane, along its own axes or along others; or too thin.
model::Affine flat_frame(Random& random) {
  const model::Affine turn = random_frame(random, Frames::kRigid);
  model::Affine scale;
  const std::size_t kind = random.below(6);
  if (kind == 0) scale.m[0] = scale.m[5] = 0;
  if (kind <= 2) scale.m[10] = 0;
  if (kind == 3) scale.m[5] = -0.0;
  if (kind == 4) scale.m[0] = 1e-14;
  if (kind == 5) scale = kNothing;
  const model::Affine placed = compose(turn, scale);
  return random.below(2) == 0 ? placed : compose(placed, random_frame(random, Frames::kRigid));
}

model::Affine any_frame(Random& random) {
  return random.below(4) == 0 ? flat_frame(random) : random_frame(random, Frames::kRigid);
}

/// Some nodes become flat in place, others get a good transform again.
model::SetTransforms flattened(Random& random, std::uint64_t nodes) {
  model::SetTransforms set;
  for (std::uint64_t i = 0; i < 1 + nodes / 10; ++i) {
    set.nodes.push_back(static_cast<model::NodeRef>(1 + random.below(nodes)));
    set.parent_from_local.push_back(any_frame(random));
  }
  return set;
}

TEST(FlatNodes, OfRandomHierarchiesComeAndGoAsTheOracleSays) {
  std::uint64_t hits = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    constexpr int kNodes = 120;
    std::vector<model::Update> updates = tests::random_hierarchy(kNodes, Frames::kRigid, seed);
    for (model::Update& update : updates) {
      if (random.below(8) == 0)
        std::get<model::PutNode>(update).parent_from_local = flat_frame(random);
    }
    Scene scene({.small_tree = 4, .at_once = 16});
    const auto applied = scene.apply(updates);
    ASSERT_TRUE(applied) << applied.error().message;
    // Odd: all of this before the first ray.
    if (seed % 2 == 0) hits += tests::expect_oracle(scene, 100, seed);
    for (int round = 0; round < 8; ++round) {
      ASSERT_TRUE(scene.apply({flattened(random, kNodes)}));
      if (round % 3 == 2) scene.merge_trees();
      hits += tests::expect_oracle(scene, 100, random.next());
    }
  }
  EXPECT_GT(hits, 3'000u);
}

TEST(FlatNodes, HideWhatIsBelowThemUntilTheyAreGoodAgain) {
  const auto mesh = tests::mesh_of(tests::cube());
  for (const model::Mobility mobility : {model::Mobility::kStatic, model::Mobility::kRigid}) {
    Scene scene;
    std::vector<model::Update> updates{put_node(-1, 0, nullptr), put_node(-2, -1, nullptr),
                                       put_node(-3, -2, mesh), put_node(-4, -3, mesh),
                                       put_node(-5, 0, mesh)};
    for (model::Update& update : updates) std::get<model::PutNode>(update).mobility = mobility;
    std::get<model::PutNode>(updates[3]).parent_from_local.m[11] = 4;
    std::get<model::PutNode>(updates[4]).parent_from_local.m[3] = 9;
    ASSERT_TRUE(scene.apply(updates));
    const Ray down{{0.1, 0.2, 50}, {0, 0, -1}};
    const auto hit = [&] {
      Hit found;
      EXPECT_TRUE(trace(*scene.snapshot(), {&down, 1}, {&found, 1}, {}));
      return found.node;
    };
    EXPECT_EQ(hit(), 4u);
    const model::Affine thin{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-13, 0}};
    const model::Affine edge{{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}};
    for (const model::Affine& flat : {kNothing, thin, edge}) {
      for (const model::NodeRef node : {1, 2, 3}) {
        ASSERT_TRUE(scene.apply({model::SetTransforms{{node}, {flat}}}));
        EXPECT_EQ(hit(), 0u) << node;
        EXPECT_EQ(scene.snapshot()->bounds().lo.x, 8) << "node 5 alone";
        EXPECT_EQ(summarize(*scene.snapshot()).instances, 3u);
        // It moves and is named as other nodes; what is below it moves, too.
        ASSERT_TRUE(scene.apply({model::SetTransforms{{4, 3}, {thin, model::Affine{}}}}));
        EXPECT_EQ(hit(), node == 3 ? 3u : 0u);
        ASSERT_TRUE(scene.apply({model::SetTransforms{{node}, {model::Affine{}}}}));
        EXPECT_EQ(hit(), 3u);
        model::Affine up;
        up.m[11] = 4;
        ASSERT_TRUE(scene.apply({model::SetTransforms{{4}, {up}}}));
        EXPECT_EQ(hit(), 4u);
      }
    }
  }
}

/// Their product is not: a node may be good, the node below it too, and no ray get through both.
TEST(FlatNodes, MayBeGoodOneByOne) {
  const auto mesh = tests::mesh_of(tests::cube());
  const model::Affine thin{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-8, 0}};
  const model::Affine thick{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e8, 0}};
  const Ray down{{0.1, 0.2, 50}, {0, 0, -1}};
  for (const model::Mobility mobility : {model::Mobility::kStatic, model::Mobility::kRigid}) {
    Scene scene;
    std::vector<model::Update> updates;
    // Enough for clusters, each group with nothing to be hit.
    for (int i = 1; i <= 100; ++i) {
      updates.emplace_back(put_node(-2 * i, 0, nullptr, thin));
      updates.emplace_back(put_node(-2 * i - 1, -2 * i, mesh, thin));
    }
    updates.emplace_back(put_node(-300, -2, mesh, thick));
    for (model::Update& update : updates) std::get<model::PutNode>(update).mobility = mobility;
    ASSERT_TRUE(scene.apply(updates));
    for (int round = 0; round < 3; ++round) {
      for (const Growth growth : {Growth::kFirstTouch, Growth::kDemand, Growth::kFull}) {
        TraceOptions options;
        options.growth = growth;
        const tests::KindAnswers answers =
            tests::ask_all_kinds(*scene.snapshot(), {&down, 1}, options);
        EXPECT_EQ(tests::contradiction(answers, options.max_hits), "");
        EXPECT_EQ(answers.closest[0].node, round == 2 ? 0u : 201u);
        EXPECT_EQ(answers.counts[0].count, round == 2 ? 0u : 2u);
      }
      if (round == 1) {
        ASSERT_TRUE(scene.apply({model::DeleteNode{201}}));
      } else {
        ASSERT_TRUE(scene.apply({model::SetTransforms{{4}, {thin}}}));
      }
    }
  }
}

TEST(FlatNodes, AreInNoShardAndHaveNoCells) {
  const auto mesh = tests::mesh_of(tests::cube());
  const auto snapshot = tests::snapshot_of(
      {put_node(-1, 0, mesh, kNothing), put_node(-2, -1, mesh), put_node(-3, 0, mesh)});
  const auto alone = tests::snapshot_of({put_node(-1, 0, mesh)});
  EXPECT_EQ(deferred_cells(*snapshot, 10).boxes, deferred_cells(*alone, 10).boxes);
  const query::ShardCut cut(*snapshot, 2);
  EXPECT_EQ(cut.shard_of(1), cut.size());
  EXPECT_EQ(cut.shard_of(2), cut.size());
  EXPECT_LT(cut.shard_of(3), cut.size());
  EXPECT_EQ(cut[0].instances + cut[1].instances, 1u);
  const query::ShardCut none(*tests::snapshot_of({put_node(-1, 0, mesh, kNothing)}), 2);
  EXPECT_EQ(none[0].instances + none[1].instances, 0u);
}

TEST(FlatNodes, AreRestoredAsTheyWere) {
  const auto mesh = tests::mesh_of(tests::cube());
  Scene scene;
  ASSERT_TRUE(scene.apply(
      {put_node(-1, 0, nullptr, kNothing), put_node(-2, -1, mesh), put_node(-3, 0, mesh)}));
  SceneContent content{.revision = 1, .next_id = 4, .nodes = {}};
  for (const model::NodeId id : {1u, 2u, 3u}) {
    model::Node node = *scene.snapshot()->find(id);
    node.is_flat = false;  // not part of what is stored
    content.nodes.push_back(node);
  }
  Scene restored;
  ASSERT_TRUE(restored.restore(std::move(content)));
  EXPECT_TRUE(restored.snapshot()->find(1)->is_flat);
  EXPECT_EQ(restored.snapshot()->trees().size(), 1u);
  ASSERT_TRUE(restored.apply({model::SetTransforms{{1}, {model::Affine{}}}}));
  EXPECT_EQ(restored.snapshot()->hierarchy().summary(0).instances, 2u);
}

}  // namespace
}  // namespace sightline::scenegraph
