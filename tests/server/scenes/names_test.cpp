// Resource names: which ones are valid, and what errors name.
#include "server/scenes/names.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace sightline::server::scenes
