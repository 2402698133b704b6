// Hierarchies over boxes: every leaf once, and no box outside of its parent's.
#include "accel/blocks/box_hierarchy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "accel/blocks/block_builder.h"
#include "tests/support/random.h"

namespace sightline::accel::blocks {
namespace {

constexpr std::uint32_t kWords[1] = {};

Node leaf_at(const geometry::Aabb& box) {
  Node leaf;
  leaf.box = box;
  leaf.words = 1;
  leaf.leaf_words = kWords;
  return leaf;
}

/// Adds the leaves below, and the areas of the inner nodes.
void visit(const Node& node, std::set<const Node*>& leaves, double& areas) {
  if (node.leaf()) {
    EXPECT_TRUE(leaves.insert(&node).second);
    return;
  }
  areas += half_area(node.box);
  for (const Node* child : {node.left, node.right}) {
    geometry::Aabb both = node.box;
    both.grow(child->box);
    EXPECT_EQ(both, node.box);
    visit(*child, leaves, areas);
  }
}

/// Joins them; returns the areas of inner nodes over that of the root.
double expect_joined(std::vector<Node> leaves) {
  std::vector<Node> nodes;
  const Node* const root = join(leaves, nodes);
  std::set<const Node*> met;
  double areas = 0;
  visit(*root, met, areas);
  EXPECT_EQ(met.size(), leaves.size());
  EXPECT_LE(root->levels, kMostLevels);
  return areas / half_area(root->box);
}

TEST(BoxHierarchy, HasEveryLeafOnce) {
  tests::Random random(1);
  for (const std::size_t count : {1, 2, 3, 17, 1000, 5000}) {
    std::vector<Node> leaves;
    for (std::size_t i = 0; i < count; ++i) {
      const auto x = [&] { return static_cast<float>(random.uniform(0, 1)); };
      const geometry::Vec3f lo{x(), x(), x()};
      leaves.push_back(leaf_at({lo, lo + geometry::Vec3f{0.02f, 0.02f, 0.02f}}));
    }
    expect_joined(std::move(leaves));
  }
}

TEST(BoxHierarchy, HasEveryLeafOnceWhereCentersAreEqualOrFar) {
  std::vector<Node> equal, far;
  for (int i = 0; i < 3000; ++i) {
    equal.push_back(leaf_at({{0, 0, 0}, {1, 1, 1}}));
    const float at = std::ldexp(1.0f, i % 100);
    far.push_back(leaf_at({{at, 0, 0}, {at + 1, 1, 1}}));
  }
  expect_joined(std::move(equal));
  expect_joined(std::move(far));
}

/// Boxes in empty bins have no bounds, which would spoil the costs of all splits.
TEST(BoxHierarchy, SeparatesDistantBoxes) {
  std::vector<Node> leaves;
  for (int i = 0; i < 512; ++i) {
    const auto x = static_cast<float>(i % 8) * 100, y = static_cast<float>(i / 8 % 8) * 100,
               z = static_cast<float>(i / 64) * 100;
    leaves.push_back(leaf_at({{x, y, z}, {x + 1, y + 1, z + 1}}));
  }
  // Halves of halves of a cube: 1, then 2 of 2/3, 4 of 4/9 ... of its area, about.
  EXPECT_LT(expect_joined(std::move(leaves)), 14);
}

}  // namespace
}  // namespace sightline::accel::blocks
