// Nodes that are seen by labels.
#include "scenegraph/query/label_filter.h"

#include <gtest/gtest.h>

#include <memory>

#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/all_instances.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using NodeIds = std::vector<model::NodeId>;
using Matches = std::vector<LabelMatch>;

model::PutNode labelled(model::PutNode put, std::vector<model::Label> labels) {
  put.labels = std::make_shared<const std::vector<model::Label>>(std::move(labels));
  return put;
}

/// Node 1, storey 1, has the window 2 and the group 3, a wall, with the mesh 4, another window; 5
/// is a mesh without labels.
std::shared_ptr<const revision::Snapshot> house() {
  const auto mesh = tests::mesh_of(tests::cube());
  Scene scene;
  EXPECT_TRUE(
      scene.apply({labelled(tests::put_node(-1, 0, nullptr), {{"storey", "1"}}),
                   labelled(tests::put_node(-2, -1, mesh), {{"class", "IfcWindow"}, {"glass", ""}}),
                   labelled(tests::put_node(-3, -1, nullptr), {{"class", "IfcWall"}}),
                   labelled(tests::put_node(-4, -3, mesh), {{"id", "7"}, {"class", "IfcWindow"}}),
                   tests::put_node(-5, 0, mesh)}));
  return scene.snapshot();
}

NodeIds seen(const Matches& only, const Matches& excluded) {
  const auto snapshot = house();
  const auto selection = Selection::make(snapshot, 0, {}, LabelFilter(only, excluded));
  EXPECT_TRUE(selection);
  NodeIds nodes;
  const auto list = tests::all_instances(snapshot->trees().static_tree());
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (selection->selects(i)) nodes.push_back(list[i].node);
  }
  return nodes;
}

TEST(LabelFilter, SeesAllWithoutAMatch) {
  EXPECT_TRUE(LabelFilter().sees_all());
  EXPECT_FALSE(LabelFilter({{"a"}}, {}).sees_all());
  EXPECT_FALSE(LabelFilter({}, {{"a"}}).sees_all());
  EXPECT_EQ(seen({}, {}), (NodeIds{2, 4, 5}));
}

TEST(LabelFilter, ExcludesWhatIsLabelledAndWhatIsUnderIt) {
  EXPECT_EQ(seen({}, {{"class", "IfcWindow"}}), (NodeIds{5}));
  EXPECT_EQ(seen({}, {{"class", "IfcWall"}}), (NodeIds{2, 5})) << "the window is under the wall";
  EXPECT_EQ(seen({}, {{"storey", "1"}}), (NodeIds{5}));
  EXPECT_EQ(seen({}, {{"storey", "2"}, {"CLASS", "IfcWall"}}), (NodeIds{2, 4, 5}));
  EXPECT_EQ(seen({}, {{"id", "7"}, {"glass", ""}}), (NodeIds{5})) << "any match counts";
}

TEST(LabelFilter, SeesOnlyWhatIsLabelledAndWhatIsUnderIt) {
  EXPECT_EQ(seen({{"storey", "1"}}, {}), (NodeIds{2, 4}));
  EXPECT_EQ(seen({{"class", "IfcWall"}, {"glass", ""}}, {}), (NodeIds{2, 4}));
  EXPECT_EQ(seen({{"class", "none"}}, {}), NodeIds{});
  EXPECT_EQ(seen({{"storey", "1"}}, {{"class", "IfcWall"}}), (NodeIds{2}));
}

TEST(LabelFilter, AKeyAloneMatchesAnyValueAndAnEmptyValueOnlyThat) {
  EXPECT_EQ(seen({{"class"}}, {}), (NodeIds{2, 4}));
  EXPECT_EQ(seen({{"class", ""}}, {}), NodeIds{});
  EXPECT_EQ(seen({{"glass", ""}}, {}), (NodeIds{2}));
  EXPECT_EQ(seen({{"class", "IfcWall"}, {"class"}, {"class", "none"}}, {}), (NodeIds{2, 4}));
  EXPECT_EQ(seen({{"class", "z"}, {"class", "IfcWindow"}, {"class", "a"}}, {}), (NodeIds{2, 4}));
}

/// The labels of groups are looked at once, or this would take hours.
TEST(LabelFilter, LooksAtManyLabelsOfAGroupOnce) {
  constexpr int kGroups = model::kMaxDepth - 1, kLeaves = 20'000;
  Scene scene;
  std::vector<model::Update> updates;
  for (int i = 1; i <= kGroups; ++i) {
    std::vector<model::Label> labels;
    for (int k = 0; k < 64; ++k) labels.push_back({"key" + std::to_string(k), std::to_string(i)});
    updates.emplace_back(labelled(tests::put_node(-i, 1 - i, nullptr), std::move(labels)));
  }
  const auto mesh = tests::mesh_of(tests::cube());
  for (int i = 1; i <= kLeaves; ++i)
    updates.emplace_back(tests::put_node(-kGroups - i, -kGroups, mesh));
  ASSERT_TRUE(scene.apply(updates));
  Matches only;
  for (int k = 0; k < 64; ++k) only.push_back({"key" + std::to_string(k), "0"});
  const auto snapshot = scene.snapshot();
  const LabelView none(*snapshot, LabelFilter(only, {}));
  only.push_back({"key63", std::to_string(kGroups)});
  const LabelView all(*snapshot, LabelFilter(only, {}));
  for (int i = 1; i <= kLeaves; ++i) {
    ASSERT_FALSE(none.sees(kGroups + i));
    ASSERT_TRUE(all.sees(kGroups + i));
  }
}

}  // namespace
}  // namespace sightline::scenegraph::query
