// Files of tokens: what they may say, and who a token is.
#include "server/security/tokens.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/server/support/token_file.h"

namespace sightline::server::security {
namespace {

using exec::Role;
using tests::hash_of;
using tests::token_row;

std::string error_of(const std::string& toml) {
  const auto parsed = Tokens::parse(toml);
  return parsed ? "" : parsed.error().message;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Tokens, AreFoundByTheirHash) {
  const auto tokens = Tokens::parse(token_row("a", "first", "read", R"("")") +
                                    token_row("b", "second", "write", R"("projects/site/")"));
  ASSERT_TRUE(tokens) << tokens.error().message;
  EXPECT_EQ(tokens->find("first")->name, "a");
  EXPECT_EQ(tokens->find("second")->name, "b");
  EXPECT_EQ(tokens->find("third"), nullptr);
  EXPECT_EQ(tokens->find(""), nullptr);
  EXPECT_EQ(tokens->find(hash_of("first")), nullptr) << "a hash is no token";
}

TEST(Tokens, APrefixNamesItsProjectWhole) {
  const auto tokens = Tokens::parse(
      token_row("a", "t", "read", R"("projects/site", "projects/lab/scenes/robot-", "yard")"));
  ASSERT_TRUE(tokens) << tokens.error().message;
  const auto principal = tokens->find("t");
  EXPECT_TRUE(principal->may(Role::kRead, "projects/site/scenes/s"));
  EXPECT_FALSE(principal->may(Role::kRead, "projects/site2/scenes/s"));
  EXPECT_TRUE(principal->may(Role::kRead, "projects/lab/scenes/robot-7"));
  EXPECT_FALSE(principal->may(Role::kRead, "projects/lab/scenes/other"));
  EXPECT_TRUE(principal->may(Role::kRead, "projects/default/scenes/yard"));
}

TEST(Tokens, GrantsOfOneHashAddUp) {
  const auto tokens = Tokens::parse(token_row("a", "t", "read", R"("")") +
                                    token_row("a", "t", "admin", R"("projects/mine/")"));
  ASSERT_TRUE(tokens) << tokens.error().message;
  EXPECT_TRUE(tokens->find("t")->may(Role::kRead, "projects/other/scenes/s"));
  EXPECT_FALSE(tokens->find("t")->may(Role::kWrite, "projects/other/scenes/s"));
  EXPECT_TRUE(tokens->find("t")->may(Role::kAdmin, "projects/mine/scenes/s"));
}

TEST(Tokens, AnEqualTokenKeepsItsPrincipal) {
  const std::string same = token_row("a", "same", "read", R"("")");
  const auto old = Tokens::parse(same + token_row("b", "changed", "read", R"("")"));
  auto fresh = Tokens::parse(same + token_row("b", "changed", "write", R"("")"));
  ASSERT_TRUE(old && fresh);
  fresh->keep_equal(*old);
  EXPECT_EQ(fresh->find("same"), old->find("same"));
  EXPECT_NE(fresh->find("changed"), old->find("changed"));
}

TEST(Tokens, ErrorsNameTheLineAndNoSecret) {
  const std::string good = token_row("a", "t", "read", R"("")");
  EXPECT_TRUE(contains(error_of(""), "no [[token]]"));
  EXPECT_TRUE(contains(error_of("[[token"), "line 1"));
  EXPECT_TRUE(contains(error_of(good + "[[token]]\nnmae = 'x'\n"), "\"nmae\" is no known key"));
  EXPECT_TRUE(contains(error_of("limit = 1\n" + good), "\"limit\" is no known key"));
  EXPECT_TRUE(contains(error_of(token_row("a b", "t", "read", R"("")")), "\"a b\""));
  EXPECT_TRUE(contains(error_of(token_row("a", "t", "root", R"("")")), "\"root\""));
  EXPECT_TRUE(contains(error_of(token_row("a", "t", "read", "")), "all scenes"));
  EXPECT_TRUE(contains(error_of(token_row("a", "t", "read", "1")), "not a string"));
  EXPECT_TRUE(contains(error_of(good + token_row("b", "t", "read", R"("")")), "one sha256"));
  const std::string secret =
      error_of("[[token]]\nname='a'\nsha256='my-secret-token'\nrole='read'\nscenes=['']\n");
  EXPECT_TRUE(contains(secret, "64 hex digits")) << secret;
  EXPECT_FALSE(contains(secret, "my-secret")) << secret;
}

}  // namespace
}  // namespace sightline::server::security
