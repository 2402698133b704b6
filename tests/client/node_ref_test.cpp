// What names a node, and what does not compile.
#include "client/node_ref.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "client/update.h"

namespace sightline::client {
namespace {

static_assert(std::is_convertible_v<std::uint64_t, NodeRef>);
static_assert(std::is_convertible_v<int, NodeRef>);
static_assert(std::is_convertible_v<NodeRef, std::int64_t>);
static_assert(!std::is_convertible_v<double, NodeRef>);
static_assert(!std::is_convertible_v<bool, NodeRef>);
static_assert(!std::is_convertible_v<std::string, NodeRef>);
static_assert(std::is_convertible_v<std::vector<std::uint64_t>, NodeRefs>);
static_assert(std::is_convertible_v<std::vector<NodeRef>, NodeRefs>);
static_assert(!std::is_convertible_v<std::vector<double>, NodeRefs>);
static_assert(!std::is_convertible_v<std::string, Update>);

TEST(NodeRef, IsAnIdOrAnAlias) {
  const std::uint64_t id = 7;
  EXPECT_EQ(NodeRef(id), 7);
  EXPECT_EQ(NodeRef(-3), -3);
  EXPECT_EQ(NodeRef(), 0);
  EXPECT_EQ(NodeRef(std::int8_t{-1}), -1);
  NodeRef alias = -1;
  EXPECT_EQ(alias--, -1);
  EXPECT_EQ(--alias, -3);
  EXPECT_EQ(++alias, -2);
  EXPECT_EQ(alias++, -2);
  EXPECT_EQ(-1 - alias, 0);
}

// Such an id must not become an alias.
TEST(NodeRef, AnIdThatNoNodeHasStaysPositive) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(NodeRef(std::numeric_limits<std::uint64_t>::max()), kMost);
  EXPECT_EQ(NodeRef(std::uint64_t{1} << 63), kMost);
  EXPECT_EQ(NodeRef(static_cast<std::uint64_t>(kMost)), kMost);
}

TEST(NodeRef, UpdatesTakeTheIdsOfHits) {
  const std::vector<std::uint64_t> node{4, 5};
  const SetTransforms set{.nodes = node, .parent_from_local = {kIdentity, kIdentity}};
  EXPECT_EQ(set.nodes, (std::vector<NodeRef>{4, 5}));
  const PutNode put{.node = -1, .parent = node[0]};
  EXPECT_EQ(put.parent, 4);
  const std::vector<Update> updates{DeleteNode{node[1], true},
                                    SetTransforms{{node[0]}, {kIdentity}},
                                    PatchVertices{std::array<std::uint64_t, 1>{9}, 0, {}}};
  EXPECT_EQ(std::get<DeleteNode>(updates[0]).node, 5);
  EXPECT_EQ(std::get<SetTransforms>(updates[1]).nodes, std::vector<NodeRef>{4});
  EXPECT_EQ(std::get<PatchVertices>(updates[2]).nodes, std::vector<NodeRef>{9});
}

TEST(NodeRef, IsANumberToTheStandardLibrary) {
  EXPECT_EQ(std::numeric_limits<NodeRef>::min(), std::numeric_limits<std::int64_t>::min());
  const std::unordered_map<NodeRef, int> ages{{-1, 3}};
  EXPECT_EQ(ages.at(-1), 3);
}

}  // namespace
}  // namespace sightline::client
