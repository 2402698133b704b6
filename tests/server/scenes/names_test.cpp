// Resource names: what is taken, and what an error names. Tokens there and back.
#include "server/scenes/names.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace sightline::server::scenes {
namespace {

TEST(Names, AcceptsIdsOfTheDocumentedAlphabet) {
  EXPECT_TRUE(check_scene_name("projects/p/scenes/s"));
  EXPECT_TRUE(check_scene_name("projects/default/scenes/0a.b_c-d"));
  EXPECT_TRUE(check_scene_name("projects/p/scenes/" + std::string(63, 'a')));
}

TEST(Names, RefusesOtherIdsAndNamesThem) {
  for (const std::string id : {"", "A", ".a", "-a", "a b", "a/b", "\xc3\xa4", "a\n"}) {
    const Status status = check_scene_name("projects/p/scenes/" + id);
    ASSERT_FALSE(status) << id;
    EXPECT_EQ(status.error().code, Code::kInvalidArgument);
  }
  EXPECT_NE(check_scene_name("projects/p/scenes/Hall").error().message.find("scene id \"Hall\""),
            std::string::npos);
  EXPECT_NE(check_scene_name("projects/P/scenes/s").error().message.find("project id \"P\""),
            std::string::npos);
  EXPECT_FALSE(check_scene_name("projects/p/scenes/" + std::string(64, 'a')));
}

TEST(Names, RefusesOtherShapes) {
  for (const char* name : {"", "s", "projects/p", "projects/scenes/s", "scenes/s",
                           "projects//scenes/s", "projects/p/scenes"}) {
    EXPECT_FALSE(check_scene_name(name)) << name;
  }
  EXPECT_TRUE(check_project_name("projects/p"));
  EXPECT_FALSE(check_project_name("projects/p/"));
  EXPECT_FALSE(check_project_name("p"));
}

TEST(Names, HasAProject) { EXPECT_EQ(project_of("projects/p/scenes/s"), "projects/p"); }

TEST(Names, AnErrorIsShortForAnyLengthOfTheName) {
  EXPECT_LT(check_scene_name(std::string(100'000, 'x')).error().message.size(), 300u);
}

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
