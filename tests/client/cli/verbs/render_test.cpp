// sightline render: its flags, and what it says of a picture.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/support/run_program.h"

namespace sightline::client::cli::verbs {
namespace {

using nlohmann::json;
using tests::run_program;

constexpr const char* kFloor = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 4 3 2\nf 4 2 1\n";

class Render : public tests::LiveProgram {
 protected:
  Render() {
    const std::string file = dir_.write("square.obj", kFloor);
    EXPECT_EQ(run_program({"scene", "import", "s", file}).exit, 0);
  }
};

TEST_F(Render, OnlyPngFilesAreWritten) {
  for (const char* name : {"p.jpg", "p.PNG.gz", "png", "p"}) {
    const auto refused = run_program({"render", "s", "--out", dir_.path(name), "--size", "4x4"});
    EXPECT_EQ(refused.exit, 2) << name;
    EXPECT_NE(refused.err.find(".png"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(run_program({"render", "s", "--out", dir_.path("p.PNG"), "--size", "4x4"}).exit, 0);
  EXPECT_EQ(dir_.names(), "p.PNG square.obj");
}

TEST_F(Render, APictureOnStandardOutputStandsAlone) {
  const auto picture = run_program({"render", "s", "--out", "-", "--size", "4x4"});
  EXPECT_EQ(picture.exit, 0);
  EXPECT_EQ(picture.out.substr(1, 3), "PNG");
  EXPECT_EQ(picture.out.substr(picture.out.size() - 8, 4), "IEND");
  EXPECT_EQ(run_program({"render", "s", "--out", "-", "--json"}).exit, 2);
}

TEST_F(Render, UpIsAnAxisOrADirection) {
  const std::string out = dir_.path("p.png");
  for (const char* up : {"x", "y", "z", "0,0,-1", "1,1,0"})
    EXPECT_EQ(run_program({"render", "s", "--out", out, "--size", "4x4", "--up", up}).exit, 0);
  for (const char* up : {"up", "0,0,0", "1,2"})
    EXPECT_EQ(run_program({"render", "s", "--out", out, "--size", "4x4", "--up", up}).exit, 2);
}

TEST_F(Render, EveryModeHasParallelRays) {
  const std::string out = dir_.path("p.png");
  for (const char* mode : {"normal", "lit", "depth", "node", "heat"}) {
    const auto picture = run_program(
        {"render", "s", "--out", out, "--size", "40x40", "--mode", mode, "--ortho", "--json"});
    ASSERT_EQ(picture.exit, 0) << picture.err;
    EXPECT_GT(json::parse(picture.out)["hits"], 1000) << mode;
  }
}

TEST_F(Render, TheScaleOfDepthIsReportedAndMayBeLeftOut) {
  const std::string out = dir_.path("p.png");
  const auto depth = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"render",  "s",      "--out", out,     "--size",
                                       "300x120", "--mode", "depth", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(run_program(arguments).out);
  };
  const json with = depth({}), without = depth({"--no-scale"});
  EXPECT_EQ(with["scale"]["unit"], "units");
  EXPECT_LT(with["scale"]["low"], with["scale"]["high"]);
  EXPECT_EQ(without["rays"], 300 * 120 * 4);
  EXPECT_LT(with["rays"], without["rays"]) << "the scale takes its columns from the view";
  EXPECT_EQ(with["width"], 300);
}

}  // namespace
}  // namespace sightline::client::cli::verbs
