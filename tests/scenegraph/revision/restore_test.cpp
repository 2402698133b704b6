// Scenes that are written down and read again, and revisions that are published later or dropped.
#include "scenegraph/revision/restore.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/random_edits.h"

namespace sightline::scenegraph::revision {
namespace {

void write_down(const Snapshot& snapshot, const model::ChildList& ids,
                std::vector<model::Node>& nodes) {
  for (const model::NodeId id : ids) {
    nodes.push_back(*snapshot.find(id));
    write_down(snapshot, snapshot.find(id)->children, nodes);
  }
}

SceneContent content_of(const Scene& scene) {
  const auto snapshot = scene.snapshot();
  SceneContent content{snapshot->revision(), scene.state().next_id, {}};
  write_down(*snapshot, snapshot->roots(), content.nodes);
  return content;
}

void expect_same(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.revision(), b.revision());
  ASSERT_EQ(a.node_count(), b.node_count());
  EXPECT_TRUE(std::ranges::equal(a.roots(), b.roots()));
  a.nodes().for_each([&](model::NodeId id, const std::shared_ptr<const model::Node>& node) {
    const model::Node* other = b.find(id);
    ASSERT_NE(other, nullptr) << id;
    EXPECT_EQ(node->parent, other->parent);
    EXPECT_EQ(node->name, other->name);
    EXPECT_EQ(node->parent_from_local, other->parent_from_local);
    EXPECT_EQ(node->mesh, other->mesh);
    EXPECT_EQ(node->mesh_digest, other->mesh_digest);
    EXPECT_EQ(node->patched, other->patched);
    EXPECT_EQ(node->mobility, other->mobility);
    EXPECT_EQ(node->mask, other->mask);
    EXPECT_TRUE(std::ranges::equal(node->children, other->children));
  });
  EXPECT_EQ(a.hierarchy().summary(0).triangles, b.hierarchy().summary(0).triangles);
  EXPECT_EQ(a.hierarchy().summary(0).mesh_nodes, b.hierarchy().summary(0).mesh_nodes);
  EXPECT_EQ(a.hierarchy().summary(0).height, b.hierarchy().summary(0).height);
}

TEST(Restore, RestoredScenesTakeTheSameBatchesAsTheirOriginals) {
  const auto meshes = tests::small_meshes();
  tests::RandomEdits edits(meshes, 11);
  tests::RandomEdit edit = tests::ground(meshes);
  Scene scene;
  ASSERT_TRUE(scene.apply(edit.updates));
  for (int i = 0; i < 60; ++i) {
    Scene restored;
    ASSERT_TRUE(restored.restore(content_of(scene)));
    expect_same(*scene.snapshot(), *restored.snapshot());
    tests::PlainScene now = edit.after;
    tests::RandomEdit next = edits.next(now);
    const auto applied = scene.apply(next.updates);
    const auto again = restored.apply(next.updates);
    ASSERT_EQ(static_cast<bool>(applied), static_cast<bool>(again));
    ASSERT_EQ(static_cast<bool>(applied), !next.refusal);
    if (!applied) continue;
    EXPECT_EQ(applied->nodes, again->nodes);
    EXPECT_EQ(applied->revision, again->revision);
    edit = std::move(next);
  }
}

TEST(Restore, RefusesWhatIsNoScene) {
  const auto refused = [](std::vector<model::Node> nodes, model::NodeId next_id = 10000) {
    Scene scene;
    const Status restored = scene.restore({1, next_id, std::move(nodes)});
    return !restored && restored.error().code == Code::kDataLoss;
  };
  const auto node = [](model::NodeId id, model::NodeId parent) {
    model::Node made;
    made.id = id;
    made.parent = parent;
    return made;
  };
  EXPECT_FALSE(refused({node(1, 0), node(2, 1)}));
  EXPECT_TRUE(refused({node(0, 0)}));
  EXPECT_TRUE(refused({node(2, 1), node(1, 0)}));
  EXPECT_TRUE(refused({node(1, 0), node(1, 0)}));
  EXPECT_TRUE(refused({node(5, 0)}, 5));
  std::vector<model::Node> chain;
  for (model::NodeId id = 1; id <= model::kMaxDepth; ++id) chain.push_back(node(id, id - 1));
  EXPECT_FALSE(refused(chain));
  chain.push_back(node(chain.size() + 1, chain.size()));
  EXPECT_TRUE(refused(chain));
}

TEST(Unpublished, RevisionsAreSeenWhenTheyArePublished) {
  Scene scene;
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, nullptr)}, {.publish = false}));
  EXPECT_EQ(scene.snapshot()->revision(), 0u);
  EXPECT_EQ(scene.head()->revision(), 3u);
  scene.publish_next();
  EXPECT_EQ(scene.snapshot()->revision(), 1u);
  EXPECT_EQ(scene.state().next_id, 2u);
  EXPECT_EQ(scene.head()->revision(), 3u);
}

TEST(Unpublished, ADroppedRevisionLeavesNoTrace) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, nullptr)}));
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 1, nullptr)}, {.publish = false}));
  scene.drop_unpublished();
  EXPECT_EQ(scene.head(), scene.snapshot());
  const auto applied = scene.apply({tests::put_node(-1, 1, nullptr)});
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->revision, 2u);
  EXPECT_EQ(applied->nodes, (std::vector<model::NodeId>{2}));
}

TEST(Unpublished, DroppingTreesKeepsBothRevisions) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, nullptr)}));
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 1, nullptr)}, {.publish = false}));
  static_cast<void>(scene.snapshot()->trees());
  scene.drop_trees();
  EXPECT_EQ(scene.snapshot()->revision(), 1u);
  EXPECT_EQ(scene.head()->revision(), 2u);
  scene.publish_next();
  EXPECT_EQ(scene.snapshot()->node_count(), 2u);
}

}  // namespace
}  // namespace sightline::scenegraph::revision
