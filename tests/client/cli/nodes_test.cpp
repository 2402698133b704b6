// Nodes by id, by name and by path.
#include "client/cli/nodes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::client::cli {
namespace {

std::vector<NodeInfo> hall() {
  const auto node = [](std::uint64_t id, std::uint64_t parent, const char* name) {
    NodeInfo info;
    info.id = id;
    info.parent = parent;
    info.name = name;
    return info;
  };
  return {node(1, 0, "hall"), node(2, 1, "shelf"), node(3, 1, "door"), node(4, 2, "box"),
          node(5, 3, "box"),  node(6, 1, "a/b"),   node(7, 0, "box")};
}

TEST(Nodes, AreFoundByIdNameOrPath) {
  const auto nodes = hall();
  const auto find = [&](const char* word) { return *find_node(nodes, word); };
  EXPECT_EQ(find("door"), 3U);
  EXPECT_EQ(find("shelf/box"), 4U);
  EXPECT_EQ(find("hall/door/box"), 5U);
  EXPECT_EQ(find("/hall"), 1U);
  EXPECT_EQ(find("/box"), 7U);
  EXPECT_EQ(find("a/b"), 6U);
  EXPECT_EQ(find("hall/a/b"), 6U);
  EXPECT_EQ(find("99"), 99U) << "the server judges ids";
}

TEST(Nodes, FaultsTellWhatMayHelp) {
  const auto nodes = hall();
  const auto fault = [&](const char* word) { return find_node(nodes, word).error(); };
  EXPECT_EQ(fault("dor").message, "there is no node 'dor', did you mean 'door'?");
  EXPECT_EQ(fault("dor").code, Code::kNotFound);
  EXPECT_EQ(fault("window").message, "there is no node 'window'");
  EXPECT_EQ(fault("box").message, "3 nodes are 'box': name one by its id (4 5 7)");
  EXPECT_EQ(fault("/door").message, "there is no node '/door', did you mean 'door'?");
}

}  // namespace
}  // namespace sightline::client::cli
