// Batches of updates: all or nothing, and refused updates.
#include "scenegraph/scene.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <optional>
#include <thread>

#include "accel/kdtree/epoch.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/watched_rule.h"

namespace sightline::scenegraph {
namespace {

std::shared_ptr<const model::Mesh> triangle() {
  static const auto kMesh = *model::Mesh::make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  return kMesh;
}

model::PutNode put(model::NodeRef node, model::NodeRef parent, std::string name,
                   bool mesh = false) {
  model::PutNode p;
  p.node = node;
  p.parent = parent;
  p.name = std::move(name);
  if (mesh) {
    p.mesh = triangle();
    p.mesh_digest = "digest";
  }
  return p;
}

model::Affine shifted(double x) { return model::Affine{{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}; }

/// Expects a refusal with this reason and an unchanged scene.
void expect_refused(Scene& scene, const std::vector<model::Update>& updates, Code code,
                    const std::string& reason) {
  const auto before = scene.snapshot();
  const auto result = scene.apply(updates);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, code) << result.error().message;
  EXPECT_EQ(result.error().reason, reason) << result.error().message;
  EXPECT_EQ(scene.snapshot(), before);
}

TEST(Scene, BeginsEmptyAtRevisionZero) {
  const Scene scene;
  EXPECT_EQ(scene.snapshot()->revision(), 0u);
  EXPECT_EQ(scene.snapshot()->node_count(), 0u);
}

TEST(Scene, AcceptsAHierarchyInOneBatch) {
  Scene scene;
  const auto applied =
      scene.apply({put(-1, 0, "root"), put(-2, -1, "arm"), put(-3, -2, "hand", true)});
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->revision, 1u);
  EXPECT_EQ(applied->nodes, (std::vector<model::NodeId>{1, 2, 3}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(snapshot->roots(), std::vector<model::NodeId>{1});
  EXPECT_EQ(snapshot->find(3)->parent, 2u);
  EXPECT_EQ(snapshot->find(2)->children, std::vector<model::NodeId>{3});
  EXPECT_EQ(snapshot->find(4), nullptr);
}

TEST(Scene, LabelsBelongToARevisionAndAPutReplacesThem) {
  Scene scene;
  model::PutNode labelled = put(-1, 0, "window");
  labelled.labels =
      std::make_shared<const std::vector<model::Label>>(std::vector<model::Label>{{"a", "1"}});
  ASSERT_TRUE(scene.apply({labelled}));
  const auto before = scene.snapshot();
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {shifted(1)}}}));
  EXPECT_EQ(scene.snapshot()->find(1)->labels, before->find(1)->labels) << "a move shares them";
  ASSERT_TRUE(scene.apply({put(1, 0, "window")}));
  EXPECT_EQ(scene.snapshot()->find(1)->labels, nullptr);
  EXPECT_EQ((*before->find(1)->labels)[0].value, "1");
}

TEST(Scene, RefusesLabelsBeyondTheirLimits) {
  Scene scene;
  model::PutNode labelled = put(-1, 0, "window");
  labelled.labels = std::make_shared<const std::vector<model::Label>>(
      std::vector<model::Label>{{"a", "1"}, {"a", "2"}});
  expect_refused(scene, {labelled}, Code::kInvalidArgument, "LABEL_TWICE");
}

TEST(Scene, SnapshotsAreImmutableAndShareUnchangedParts) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, 0, "b")}));
  const auto first = scene.snapshot();
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {shifted(5)}}}));
  const auto second = scene.snapshot();
  EXPECT_EQ(second->revision(), 2u);
  EXPECT_EQ(first->find(1)->parent_from_local, model::Affine{});
  EXPECT_EQ(second->find(1)->parent_from_local, shifted(5));
  EXPECT_EQ(first->find(2), second->find(2));
}

TEST(Scene, IdsAreNeverReused) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a")}));
  ASSERT_TRUE(scene.apply({model::DeleteNode{1}}));
  expect_refused(scene, {put(-1, 0, "b"), model::DeleteNode{99}}, Code::kNotFound,
                 "NODE_NOT_FOUND");
  EXPECT_EQ(scene.apply({put(-1, 0, "b")})->nodes, std::vector<model::NodeId>{2});
}

TEST(Scene, ReplacesAndMovesNodes) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, 0, "b"), put(-3, 1 - 2, "c", true)}));
  ASSERT_TRUE(scene.apply({put(3, 2, "moved", true)}));
  const auto s = scene.snapshot();
  EXPECT_TRUE(s->find(1)->children.empty());
  EXPECT_EQ(s->find(2)->children, std::vector<model::NodeId>{3});
  EXPECT_EQ(s->find(3)->name, "moved");
  ASSERT_TRUE(scene.apply({put(3, 0, "root now", true)}));
  EXPECT_EQ(scene.snapshot()->roots(), (std::vector<model::NodeId>{1, 2, 3}));
}

TEST(Scene, DeletesSubtreesOnlyOnRequest) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, -1, "b"), put(-3, -2, "c")}));
  expect_refused(scene, {model::DeleteNode{1}}, Code::kFailedPrecondition, "NODE_HAS_CHILDREN");
  ASSERT_TRUE(scene.apply({model::DeleteNode{2, true}}));
  EXPECT_EQ(scene.snapshot()->node_count(), 1u);
  EXPECT_TRUE(scene.snapshot()->find(1)->children.empty());
  expect_refused(scene, {put(3, 0, "gone")}, Code::kNotFound, "NODE_NOT_FOUND");
}

TEST(Scene, RefusesCyclesUnknownNodesAndDepth) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, -1, "b"), put(-3, -2, "c")}));
  expect_refused(scene, {put(1, 3, "a")}, Code::kInvalidArgument, "NODE_CYCLE");
  expect_refused(scene, {put(1, 1, "a")}, Code::kInvalidArgument, "NODE_CYCLE");
  expect_refused(scene, {put(-9, 77, "x")}, Code::kNotFound, "PARENT_NOT_FOUND");
  expect_refused(scene, {put(-9, -8, "x")}, Code::kNotFound, "PARENT_NOT_FOUND");
  expect_refused(scene, {put(77, 0, "x")}, Code::kNotFound, "NODE_NOT_FOUND");
  expect_refused(scene, {put(0, 0, "x")}, Code::kNotFound, "NODE_NOT_FOUND");
  expect_refused(scene, {model::SetTransforms{{77}, {model::Affine{}}}}, Code::kNotFound,
                 "NODE_NOT_FOUND");
  std::vector<model::Update> chain;
  for (int i = 1; i <= model::kMaxDepth + 1; ++i)
    chain.push_back(put(-i, i == 1 ? 0 : -i + 1, "n"));
  expect_refused(scene, chain, Code::kInvalidArgument, "TOO_DEEP");
  chain.pop_back();
  EXPECT_TRUE(scene.apply(chain));
}

/// A chain of `count` nodes, -first, -first - 1, ..., below `top`.
std::vector<model::Update> chain_below(model::NodeRef top, int first, int count) {
  std::vector<model::Update> chain;
  for (int i = 0; i < count; ++i)
    chain.push_back(put(-first - i, i == 0 ? top : -first - i + 1, "n"));
  return chain;
}

TEST(Scene, TakesTheDepthOfTheWholeHierarchy) {
  Scene scene;
  ASSERT_TRUE(scene.apply(chain_below(0, 1, 1000)));  // 1 to 1000
  ASSERT_TRUE(scene.apply(chain_below(0, 1, 25)));    // 1001 to 1025
  expect_refused(scene, {put(1001, 1000, "n")}, Code::kInvalidArgument, "TOO_DEEP");
  EXPECT_TRUE(scene.apply({put(1001, 999, "n")}));
  EXPECT_EQ(scene.snapshot()->hierarchy().summary(0).height, model::kMaxDepth + 1u);
  expect_refused(scene, {put(-1, 1025, "n")}, Code::kInvalidArgument, "TOO_DEEP");
  expect_refused(scene, {put(1001, 1025, "n")}, Code::kInvalidArgument, "NODE_CYCLE");
  // Only the end of a batch counts.
  EXPECT_TRUE(scene.apply({put(1001, 1000, "n"), put(1001, 0, "n")}));
  EXPECT_EQ(scene.snapshot()->hierarchy().summary(0).height, 1001u);
}

TEST(Scene, NamesBothNumbersWhereItIsTooDeep) {
  Scene scene;
  const auto refused = scene.apply(chain_below(0, 1, 5000));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("1025"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("1024"), std::string::npos) << refused.error().message;
}

TEST(Scene, AChildThatCameBackIsTheLast) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, -1, "b"), put(-3, -1, "c"), put(-4, 0, "d")}));
  ASSERT_TRUE(scene.apply({put(2, 4, "b"), put(2, 1, "b"), put(2, 4, "b"), put(2, 1, "b")}));
  EXPECT_EQ(scene.snapshot()->find(1)->children, (std::vector<model::NodeId>{3, 2}));
  EXPECT_TRUE(scene.snapshot()->find(4)->children.empty());
  ASSERT_TRUE(scene.apply({put(3, 4, "c"), put(3, 1, "c"), put(3, 4, "c")}));
  EXPECT_EQ(scene.snapshot()->find(1)->children, (std::vector<model::NodeId>{2}));
  EXPECT_EQ(scene.snapshot()->find(4)->children, (std::vector<model::NodeId>{3}));
}

/// What hangs below a node is not visited at each move: else these are 6,000,000,000 visits.
TEST(Scene, MovesALargeSubtreeManyTimesInABatch) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "here"), put(-2, 0, "there"), put(-3, -1, "large")}));
  std::vector<model::Update> children, moves;
  for (int i = 1; i <= 100'000; ++i) children.push_back(put(-i, 3, "n"));
  ASSERT_TRUE(scene.apply(children));
  for (int i = 0; i < 60'000; ++i) moves.push_back(put(3, i % 2 == 0 ? 2 : 1, "large"));
  ASSERT_TRUE(scene.apply(moves));
  EXPECT_EQ(scene.snapshot()->find(3)->parent, 1u);
}

/// Nor are its siblings.
TEST(Scene, MovesManySiblingsToAndFroInABatch) {
  Scene scene;
  std::vector<model::Update> nodes{put(-1, 0, "many"), put(-2, 0, "other")}, moves;
  for (int i = 3; i <= 50'000; ++i) nodes.push_back(put(-i, -1, "n"));
  ASSERT_TRUE(scene.apply(nodes));
  for (model::NodeRef id = 3; id <= 50'000; ++id) {
    moves.push_back(put(id, 2, "n"));
    moves.push_back(put(id, 1, "n"));
  }
  ASSERT_TRUE(scene.apply(moves));
  EXPECT_EQ(scene.snapshot()->find(1)->children.size(), 49'998u);
  EXPECT_EQ(scene.snapshot()->find(1)->children.front(), 3u);
}

/// A change below a node with many children costs little more than one below a node with few.
TEST(Scene, RevisionsShareListsOfChildren) {
  Scene scene;
  std::vector<model::Update> nodes{put(-1, 0, "many")};
  for (int i = 2; i <= 5'000; ++i) nodes.push_back(put(-i, -1, "n"));
  ASSERT_TRUE(scene.apply(nodes));
  const auto before = scene.snapshot();
  ASSERT_TRUE(scene.apply({put(-1, 1, "n"), put(1, 0, "renamed"), model::DeleteNode{4'000}}));
  const model::ChildList& after = scene.snapshot()->find(1)->children;
  EXPECT_EQ(after.size(), 4'999u);
  EXPECT_EQ(&after.front(), &before->find(1)->children.front());
}

TEST(Scene, RefusesTransformsThatAreNotFinite) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a"), put(-2, -1, "b", true)}));
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, -nan, inf, -inf}) {
    for (const std::size_t at : {0u, 3u, 6u, 11u}) {
      model::PutNode wrong = put(-1, 0, "wrong");
      wrong.parent_from_local.m[at] = bad;
      expect_refused(scene, {wrong}, Code::kInvalidArgument, "NOT_FINITE");
      expect_refused(scene, {model::SetTransforms{{2}, {wrong.parent_from_local}}},
                     Code::kInvalidArgument, "NOT_FINITE");
    }
  }
  model::PutNode wrong = put(-1, 0, "wrong");
  wrong.parent_from_local.m[5] = -nan;
  EXPECT_EQ(scene.apply({wrong}).error().message,
            "update 0: the transform of node \"wrong\" holds nan, which is not finite");
  expect_refused(scene, {model::SetTransforms{{1, 2}, {model::Affine{}}}}, Code::kInvalidArgument,
                 "COUNT_MISMATCH");
}

/// Each transform alone is good.
TEST(Scene, RefusesCoordinatesBeyondDoubles) {
  Scene scene;
  const model::Affine huge{{1e100, 0, 0, 0, 0, 1e100, 0, 0, 0, 0, 1e100, 0}};
  std::vector<model::Update> chain = chain_below(0, 1, 4);
  std::get<model::PutNode>(chain.back()).mesh = triangle();
  for (model::Update& node : chain) std::get<model::PutNode>(node).parent_from_local = huge;
  expect_refused(scene, chain, Code::kInvalidArgument, "NOT_FINITE");
  std::get<model::PutNode>(chain.front()).parent_from_local = {};
  ASSERT_TRUE(scene.apply(chain));
  expect_refused(scene, {model::SetTransforms{{1}, {huge}}}, Code::kInvalidArgument, "NOT_FINITE");
  // Where a node above is flat, there are no coordinates.
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1, 2}, {huge, model::Affine{{}}}}}));
  expect_refused(scene, {model::SetTransforms{{2}, {huge}}}, Code::kInvalidArgument, "NOT_FINITE");
}

TEST(Scene, AppliesAllOfABatchOrNothing) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a")}));
  expect_refused(scene,
                 {put(-1, 0, "b"), model::SetTransforms{{1}, {shifted(3)}}, model::DeleteNode{5}},
                 Code::kNotFound, "NODE_NOT_FOUND");
  EXPECT_EQ(scene.snapshot()->node_count(), 1u);
  EXPECT_EQ(scene.snapshot()->find(1)->parent_from_local, model::Affine{});
}

TEST(Scene, ACancelledBatchChangesNothing) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a")}));
  const std::atomic<bool> cancelled{true};
  bool published = false;
  const auto applied = scene.apply(
      {put(-1, 0, "b")},
      {.before_publish = [&](const Applied&) { published = true; }, .cancelled = &cancelled});
  EXPECT_EQ(applied.error().code, Code::kCancelled);
  EXPECT_FALSE(published);
  EXPECT_EQ(scene.snapshot()->revision(), 1u);
  EXPECT_EQ(scene.snapshot()->node_count(), 1u);
}

TEST(Scene, ChecksTheExpectedRevision) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a")}, {.expected_revision = 0}));
  const auto late = scene.apply({put(-1, 0, "b")}, {.expected_revision = 0});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::kAborted);
  EXPECT_EQ(late.error().message, "expected revision 0, but the scene is at 1");
}

TEST(Scene, SerializesWriters) {
  Scene scene;
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i) {
    writers.emplace_back([&] {
      for (int k = 0; k < 50; ++k) EXPECT_TRUE(scene.apply({put(-1, 0, "n")}));
    });
  }
  for (std::thread& t : writers) t.join();
  EXPECT_EQ(scene.snapshot()->revision(), 200u);
  EXPECT_EQ(scene.snapshot()->node_count(), 200u);
}

TEST(Scene, DroppedTreesGrowAgainAndAnswerAlike) {
  const tests::TestMesh sheet = tests::planar_sheet(60);
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(sheet))}));
  const auto rays = tests::rays_at(sheet, 2000, 1);
  std::vector<accel::geometry::Hit> before(rays.size()), after(rays.size());
  const auto pinned = scene.snapshot();
  ASSERT_TRUE(trace(*pinned, rays, before, {.growth = Growth::kFull}));
  const std::uint64_t grown = summarize_build(*pinned).bytes_trees;
  EXPECT_TRUE(pinned->is_complete());

  EXPECT_GT(scene.drop_trees(), 0u);
  EXPECT_FALSE(pinned->is_complete()) << "its meshes have other trees now";
  const auto now = scene.snapshot();
  EXPECT_EQ(now->revision(), pinned->revision());
  EXPECT_LT(summarize_build(*now).bytes_trees, grown);
  EXPECT_EQ(summarize_build(*now).triangles_built, 0u);
  EXPECT_EQ(scene.drop_trees(), 0u) << "there is nothing left to drop";

  ASSERT_TRUE(trace(*now, rays, after, {}));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(after[i].t, before[i].t);
    EXPECT_EQ(after[i].primitive, before[i].primitive);
  }
  ASSERT_TRUE(trace(*pinned, rays, after, {.growth = Growth::kFull}));
  EXPECT_EQ(after.front().t, before.front().t);
}

TEST(Scene, TreesMayBeDroppedWhileRaysUseThem) {
  const tests::TestMesh soup = tests::random_soup(3000, 0.05, 7);
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(soup))}));
  const auto rays = tests::rays_at(soup, 500, 2);
  std::vector<accel::geometry::Hit> expected(rays.size());
  ASSERT_TRUE(trace(*scene.snapshot(), rays, expected, {}));
  std::atomic<bool> done{false};
  std::thread dropping([&] {
    while (!done) scene.drop_trees();
  });
  for (int round = 0; round < 10; ++round) {
    std::vector<accel::geometry::Hit> hits(rays.size());
    const Growth growth = round % 2 == 0 ? Growth::kFull : Growth::kFirstTouch;
    ASSERT_TRUE(trace(*scene.snapshot(), rays, hits, {.growth = growth}));
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(hits[i].t, expected[i].t);
  }
  done = true;
  dropping.join();
  accel::kdtree::reclaim();  // LeakSanitizer does not see the cells of trees that wait to be freed
}

/// The mesh drops its tree whenever a cell is cut.
void expect_hits_while_dropped(Growth growth) {
  const tests::TestMesh soup = tests::random_soup(20'000, 0.05, 7);
  const model::Mesh* mesh = nullptr;
  std::atomic<int> dropped{0};
  const auto drop = [&](const accel::kdtree::CellRefs&) {
    constexpr int kTimes = 20;
    if (dropped < kTimes && mesh->drop_tree() > 0) ++dropped;
  };
  const auto made = *model::Mesh::make(soup.vertices, soup.faces,
                                       {.rule = std::make_shared<tests::WatchedRule>(drop)});
  mesh = made.get();
  Scene scene, undisturbed;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, made)}));
  ASSERT_TRUE(undisturbed.apply({tests::put_node(-1, 0, tests::mesh_of(soup))}));
  const auto rays = tests::rays_at(soup, 200, 2);
  std::vector<accel::geometry::Hit> hits(rays.size()), expected(rays.size());
  ASSERT_TRUE(trace(*scene.snapshot(), rays, hits, {.growth = growth}));
  ASSERT_TRUE(trace(*undisturbed.snapshot(), rays, expected, {}));
  for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(hits[i].t, expected[i].t);
  EXPECT_GT(dropped, 0);
}

TEST(Scene, ATreeThatIsDroppedLivesAsLongAsARayIsInIt) {
  expect_hits_while_dropped(Growth::kFirstTouch);
}

TEST(Scene, ATreeThatIsDroppedLivesAsLongAsItsBuild) { expect_hits_while_dropped(Growth::kFull); }

TEST(Summary, CountsSharedMeshesOnce) {
  Scene scene;
  ASSERT_TRUE(scene.apply({put(-1, 0, "a", true), put(-2, -1, "b", true), put(-3, 0, "group")}));
  ASSERT_TRUE(scene.apply({model::SetTransforms{{2}, {shifted(10)}}}));
  const revision::SceneSummary s = summarize(*scene.snapshot());
  EXPECT_EQ(s.nodes, 3u);
  EXPECT_EQ(s.instances, 2u);
  EXPECT_EQ(s.meshes, 1u);
  EXPECT_EQ(s.triangles_unique, 1u);
  EXPECT_EQ(s.triangles_instanced, 2u);
  EXPECT_EQ(s.bounds, (std::array<double, 6>{0, 0, 0, 11, 1, 0}));
}

}  // namespace
}  // namespace sightline::scenegraph
