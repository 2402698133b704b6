// Node names that fit into a message.
#include "client/importer/node_name.h"

#include <gtest/gtest.h>

#include <string>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

TEST(NodeName, Utf8DoesNotChange) {
  EXPECT_EQ(node_name("plain"), "plain");
  EXPECT_EQ(node_name(""), "");
  EXPECT_EQ(node_name("Gel\xC3\xA4nde \xE2\x82\xAC \xF0\x9F\x8C\xB3"),
            "Gel\xC3\xA4nde \xE2\x82\xAC \xF0\x9F\x8C\xB3");
}

TEST(NodeName, OtherBytesAreReadAsLatin1) {
  EXPECT_EQ(node_name("Gel\xE4nde"), "Gel\xC3\xA4nde");
  EXPECT_EQ(node_name("\xC0\xAF"), "\xC3\x80\xC2\xAF") << "overlong";
  EXPECT_EQ(node_name("\xED\xA0\x80"), "\xC3\xAD\xC2\xA0\xC2\x80") << "surrogate";
  EXPECT_EQ(node_name("\xE2\x82"), "\xC3\xA2\xC2\x82") << "cut off";
}

TEST(NodeName, IsCutBetweenCharactersAndKeepsItsSuffix) {
  const std::string longest(kMaxNodeName, 'x');
  EXPECT_EQ(node_name(longest), longest);
  EXPECT_EQ(node_name(longest + "y"), longest);
  EXPECT_EQ(node_name(longest, "#12"), std::string(kMaxNodeName - 3, 'x') + "#12");
  const std::string accents = std::string(kMaxNodeName - 1, 'x') + "\xC3\xA4";
  EXPECT_EQ(node_name(accents), std::string(kMaxNodeName - 1, 'x'));
}

}  // namespace
}  // namespace sightline::client::importer
