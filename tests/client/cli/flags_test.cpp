// Valid and invalid arguments.
#include "client/cli/flags.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace sightline::client::cli {
namespace {

TEST(Arguments, Numbers) {
  EXPECT_EQ(parse_number("1.5e3"), 1500);
  EXPECT_EQ(parse_number("-2"), -2);
  EXPECT_EQ(parse_number("+2"), 2);
  EXPECT_EQ(parse_number("inf"), HUGE_VAL);
  EXPECT_EQ(parse_number("-Infinity"), -HUGE_VAL);
  EXPECT_TRUE(std::isnan(parse_number("nan").value_or(0)));
  for (const char* text : {"", " ", "1 ", " 1", "1,5", "x", "1x", "--1", "+-1", "0x10", "1e999"}) {
    EXPECT_FALSE(parse_number(text)) << "'" << text << "'";
  }
}

TEST(Arguments, Vectors) {
  EXPECT_EQ(parse_vector("1,-2,3.5"), (std::array<double, 3>{1, -2, 3.5}));
  for (const char* text :
       {"", "1", "1,2", "1,2,3,4", "1,2,", ",1,2", "1,2,x", "1,2,inf", "1,2,nan"}) {
    EXPECT_FALSE(parse_vector(text)) << "'" << text << "'";
  }
}

TEST(Arguments, Sizes) {
  const auto size = parse_size("640x480");
  ASSERT_TRUE(size);
  EXPECT_EQ(size->width, 640U);
  EXPECT_EQ(size->height, 480U);
  EXPECT_TRUE(parse_size("1x8192"));
  for (const char* text :
       {"", "x", "640", "0x1", "1x0", "-1x1", "8193x1", "1x1x1", "1 x1", "99999999999x1"}) {
    EXPECT_FALSE(parse_size(text)) << "'" << text << "'";
  }
}

TEST(Arguments, SceneNames) {
  EXPECT_EQ(parse_scene_name("engine"), "projects/default/scenes/engine");
  EXPECT_EQ(parse_scene_name("2.a_b-c"), "projects/default/scenes/2.a_b-c");
  EXPECT_EQ(parse_scene_name("projects/p/scenes/s"), "projects/p/scenes/s");
  EXPECT_TRUE(parse_scene_name(std::string(63, 'a')));
  EXPECT_FALSE(parse_scene_name(std::string(64, 'a')));
  for (const char* text : {"", "Engine", "-a", ".a", "a b", "a/b", "projects/p/scenes/",
                           "projects//scenes/s", "projects/p/scenes/s/x", "project/p/scenes/s"}) {
    EXPECT_FALSE(parse_scene_name(text)) << "'" << text << "'";
  }
}

}  // namespace
}  // namespace sightline::client::cli
