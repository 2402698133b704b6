// What the command tells those who mistyped.
#include "client/cli/hints.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "tests/client/support/run_program.h"

namespace sightline::tests {
namespace {

class Hints : public LiveProgram {
 protected:
  static std::string reported(const std::vector<std::string>& words) {
    std::istringstream text(run_program(words).err);
    std::string line;
    std::getline(text, line);
    return line;
  }
};

TEST_F(Hints, OfVerbsAndFlags) {
  EXPECT_EQ(reported({"cats", "engine"}), "sightline: there is no verb 'cats'; did you mean cast?");
  EXPECT_EQ(reported({"import", "engine", "e.glb"}),
            "sightline: there is no verb 'import'; did you mean scene import?");
  EXPECT_EQ(reported({"scene", "lst"}), "sightline: there is no verb 'lst'; did you mean ls?");
  EXPECT_EQ(reported({"cast", "engine", "--kinds", "any"}),
            "sightline: cast has no flag --kinds; did you mean --kind?");
  EXPECT_EQ(reported({"cast", "engine", "--kind", "closst"}),
            "sightline: --kind is 'closst', not one of all any closest count; did you mean "
            "closest?");
  EXPECT_EQ(reported({"frobnicate"}), "sightline: there is no verb 'frobnicate'");
}

TEST_F(Hints, OfReversedWords) {
  EXPECT_EQ(reported({"engine", "cast"}),
            "sightline: 'engine' is one word too many; did you mean sightline cast engine?");
  EXPECT_EQ(reported({"scene", "engine", "show"}),
            "sightline: 'engine' is one word too many; did you mean sightline scene show engine?");
  const std::string file = dir_.write("e.obj", "v 0 0 0\n");
  EXPECT_NE(reported({"scene", "import", file, "engine"}).find("is a file: SCENE comes before it"),
            std::string::npos);
}

TEST_F(Hints, OfScenes) {
  EXPECT_NE(reported({"scene", "show", "test"}).find("; the server has no scenes"),
            std::string::npos);
  const std::string file = dir_.write("s.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_EQ(run_program({"scene", "import", "engine", file}).exit, 0);
  EXPECT_NE(reported({"scene", "show", "engin"}).find("; did you mean engine?"), std::string::npos);
  EXPECT_NE(reported({"scene", "show", "hall"}).find("; `sightline scene ls` lists what there is"),
            std::string::npos);
}

TEST_F(Hints, OfAServerThatIsNotThere) {
  EXPECT_NE(reported({"scene", "ls", "--endpoint", "127.0.0.1:1"})
                .find("; is sightlined running at 127.0.0.1:1?"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline::tests
