// sightline render: its flags, and what it says of a picture.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
  for (const char* mode : {"normal", "lit", "depth", "node", "heat", "clearance"}) {
    std::vector<std::string> words{"render", "s",      "--out", out,       "--size",
                                   "40x40",  "--mode", mode,    "--ortho", "--json"};
    if (std::string(mode) == "clearance") words.insert(words.end(), {"--of", "1"});
    const auto picture = run_program(words);
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

// A square at z = 0, and another one 3 above it.
class RenderClearance : public Render {
 protected:
  RenderClearance() {
    const std::string file =
        dir_.write("two.obj",
                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 3\n"
                   "o low\nf 1 2 3\nf 1 3 4\no high\nf 5 6 7\nf 5 7 8\n");
    EXPECT_EQ(run_program({"scene", "import", "two", file}).exit, 0);
  }

  tests::ProgramOutcome render(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render", "two", "--out", dir_.path("p.png"), "--size", "40x40"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
};

TEST_F(RenderClearance, IsReported) {
  const auto picture = render({"--mode", "clearance", "--of", "low", "--json"});
  ASSERT_EQ(picture.exit, 0) << picture.err;
  const json report = json::parse(picture.out);
  EXPECT_EQ(report["mode"], "clearance");
  EXPECT_GT(report["node"], 0);
  EXPECT_NEAR(report["least"], 3, 1e-9);
  EXPECT_NEAR(report["greatest"], 3, 1e-9);
  EXPECT_NEAR(report["scale"]["high"], 3, 1e-9);
  EXPECT_EQ(report["scale"]["low"], 0);
  const auto text = render({"--mode", "clearance", "--of", "low"});
  EXPECT_NE(text.out.find(" hits, 3 to 3 from the rest, "), std::string::npos) << text.out;
  EXPECT_EQ(render({"--mode", "clearance", "--of", "low", "--quiet"}).out, "");
}

TEST_F(RenderClearance, TheRangeIsThatOfTheColours) {
  const auto picture =
      render({"--mode", "clearance", "--of", "high", "--range", "0.5", "--context", "--json"});
  ASSERT_EQ(picture.exit, 0) << picture.err;
  EXPECT_EQ(json::parse(picture.out)["scale"]["high"], 0.5);
  EXPECT_NEAR(json::parse(picture.out)["greatest"], 3, 1e-9);
}

TEST_F(RenderClearance, ItIsSaidIfThereIsNothingElse) {
  const std::vector<std::string> words{"render", "s",     "--out",  dir_.path("p.png"),
                                       "--size", "40x40", "--mode", "clearance",
                                       "--of",   "1"};
  EXPECT_NE(run_program(words).out.find("nothing else in the scene"), std::string::npos);
  auto with_json = words;
  with_json.emplace_back("--json");
  const json report = json::parse(run_program(with_json).out);
  EXPECT_TRUE(report["least"].is_null());
  EXPECT_TRUE(report["greatest"].is_null());
}

TEST_F(RenderClearance, WhatCannotBeDrawnIsRefused) {
  struct Case {
    std::vector<std::string> more;
    int exit;
    const char* text;
  };
  for (const Case& wrong :
       {Case{{"--mode", "clearance"}, 2, "--mode: clearance is of a node: name it by --of"},
        Case{{"--of", "low"}, 2, "--of: only --mode clearance has it"},
        Case{{"--mode", "depth", "--range", "2"}, 2, "--range: only --mode clearance has it"},
        Case{{"--context"}, 2, "--context: only --mode clearance has it"},
        Case{
            {"--mode", "clearance", "--of", "low", "--range", "0"}, 2, "'0' is not a number above"},
        Case{{"--mode", "clearance", "--of", "-3"}, 2, "-3"},
        Case{{"--mode", "clearence", "--of", "low"}, 2, "did you mean clearance?"},
        Case{{"--mode", "clearance", "--of", "lo"}, 3, "there is no node 'lo'"},
        Case{{"--mode", "clearance", "--of", "99"}, 3, "99"}}) {
    const auto refused = render(wrong.more);
    EXPECT_EQ(refused.exit, wrong.exit) << refused.err;
    EXPECT_NE(refused.err.find(wrong.text), std::string::npos) << refused.err;
  }
  EXPECT_EQ(dir_.names(), "square.obj two.obj");
}

}  // namespace
}  // namespace sightline::client::cli::verbs
