// Roots and exclusions.
#include "scenegraph/query/selection.h"

#include <gtest/gtest.h>

#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/all_instances.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using tests::mesh_of;
using tests::put_node;

/// Node 1 has children 2 (a mesh) and 3 (a group with the mesh 4); 5 is a separate mesh.
std::shared_ptr<const revision::Snapshot> family() {
  const auto mesh = mesh_of(tests::cube());
  Scene scene;
  EXPECT_TRUE(
      scene.apply({put_node(-1, 0, nullptr), put_node(-2, -1, mesh), put_node(-3, -1, nullptr),
                   put_node(-4, -3, mesh), put_node(-5, 0, mesh)}));
  return scene.snapshot();
}

std::vector<model::NodeId> selected(model::NodeId root,
                                    const std::vector<model::NodeId>& excluded) {
  const auto snapshot = family();
  const auto selection = Selection::make(snapshot, root, excluded);
  EXPECT_TRUE(selection);
  std::vector<model::NodeId> nodes;
  const auto list = tests::all_instances(snapshot->trees().static_tree());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool first = selection->selects(i);
    EXPECT_EQ(selection->selects(i), first) << "remembered";
    if (first) nodes.push_back(list[i].node);
  }
  return nodes;
}

TEST(Selection, IsASubtreeWithoutSomeSubtrees) {
  using Nodes = std::vector<model::NodeId>;
  EXPECT_EQ(selected(0, {}), (Nodes{2, 4, 5}));
  EXPECT_EQ(selected(1, {}), (Nodes{2, 4}));
  EXPECT_EQ(selected(3, {}), (Nodes{4}));
  EXPECT_EQ(selected(4, {}), (Nodes{4}));
  EXPECT_EQ(selected(0, {1}), (Nodes{5}));
  EXPECT_EQ(selected(0, {5, 3, 3}), (Nodes{2}));
  EXPECT_EQ(selected(1, {3}), (Nodes{2}));
  EXPECT_EQ(selected(3, {1}), Nodes{}) << "an excluded root";
}

TEST(Selection, NamesAnUnknownNode) {
  const auto root = Selection::make(family(), 77, {});
  ASSERT_FALSE(root);
  EXPECT_EQ(root.error().code, Code::kNotFound);
  EXPECT_EQ(root.error().message, "root node 77 is not in revision 1");
  const std::vector<model::NodeId> excluded{2, 0};
  const auto none = Selection::make(family(), 1, excluded);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "excluded node 0 is not in revision 1");
}

}  // namespace
}  // namespace sightline::scenegraph::query
