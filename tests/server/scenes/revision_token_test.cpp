// Encoding and decoding of tokens.
#include "server/scenes/revision_token.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline::server::scenes {
namespace {

TEST(RevisionToken, IsReadBack) {
  for (const RevisionToken token :
       {RevisionToken{0, 0}, RevisionToken{0x0123456789abcdef, 42},
        RevisionToken{~std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()}}) {
    const auto parsed = RevisionToken::parse(token.text());
    ASSERT_TRUE(parsed) << token.text();
    EXPECT_EQ(parsed->incarnation, token.incarnation);
    EXPECT_EQ(parsed->revision, token.revision);
  }
}

TEST(RevisionToken, RefusesAnythingElse) {
  for (const char* text :
       {"", "-", "1", "0123456789abcdef", "0123456789abcdef-", "0123456789abcdef-x",
        "0123456789abcdef-1 ", "0123456789abcdeg-1", "0123456789abcdef-18446744073709551616",
        "0123456789abcdef--1", "0123456789abcdef_1"}) {
    const auto parsed = RevisionToken::parse(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, Code::kInvalidArgument);
    EXPECT_EQ(parsed.error().reason, "BAD_TOKEN");
  }
}

TEST(RevisionToken, IncarnationsDiffer) { EXPECT_NE(new_incarnation(), new_incarnation()); }

}  // namespace
}  // namespace sightline::server::scenes
