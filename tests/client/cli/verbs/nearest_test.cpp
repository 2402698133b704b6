// nearest as a filter and with files, in every format.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/support/coprocess.h"
#include "tests/client/support/run_program.h"
#include "tests/client/support/square.h"

namespace sightline::tests {
namespace {

class NearestVerb : public LiveProgram {
 protected:
  NearestVerb() {
    EXPECT_EQ(run_program({"scene", "import", "square", dir_.write("s.obj", kSquareObj)}).exit, 0);
  }

  ProgramOutcome nearest(const std::vector<std::string>& more, const std::string& points) const {
    std::vector<std::string> words{"nearest", "square", "--in", dir_.write("points.txt", points)};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
};

constexpr const char* kNearNames = "distance,node,primitive,u,v,x,y,z\n";
constexpr const char* kThreePoints = "0.75 0.25 2\n2 0 0\nnan 0 0\n";

TEST_F(NearestVerb, AnswersEachPointBeforeTheNextComes) {
  Coprocess filter({"nearest", "square", "--quiet"});
  filter.write("0.75 0.25 2\n");
  EXPECT_EQ(filter.read_line(), kNearNames);
  EXPECT_EQ(filter.read_line(), "2,2,0,0.5,0.25,0.75,0.25,0\n");
  for (int i = 0; i < 20; ++i) {
    filter.write("0.75,0.25," + std::to_string(i + 1) + "\n");
    EXPECT_EQ(filter.read_line(), std::to_string(i + 1) + ",2,0,0.5,0.25,0.75,0.25,0\n");
  }
  filter.write("-3 -4 0");
  filter.close_input();
  EXPECT_EQ(filter.read_line(), "5,2,0,0,0,0,0,0\n") << "the last line may lack its end";
  EXPECT_EQ(filter.wait(), 0);
}

TEST_F(NearestVerb, WithoutPointsThereIsALineOfNames) {
  Coprocess filter({"nearest", "square", "--quiet", "--kind", "all"});
  filter.close_input();
  EXPECT_EQ(filter.read_rest(), "point," + std::string(kNearNames));
  EXPECT_EQ(filter.wait(), 0);
}

TEST_F(NearestVerb, DistancesEndWhereTheyAreToEnd) {
  const std::vector<std::string> fields{"--no-header", "--fields", "distance,hit"};
  const auto out = [&](std::vector<std::string> more, const std::string& points) {
    more.insert(more.end(), fields.begin(), fields.end());
    return nearest(more, points).out;
  };
  EXPECT_EQ(out({}, kThreePoints), "2,1\n1,1\nnan,2\n");
  EXPECT_EQ(out({"--max-distance", "1"}, kThreePoints), "inf,0\n1,1\nnan,2\n");
  EXPECT_EQ(out({"--max-distance", "1.5"}, "0 0 2 9\n0 0 1 9\n0 0 1 0.5\n0 0 1 nan\n"),
            "inf,0\n1,1\ninf,0\nnan,2\n");
}

TEST_F(NearestVerb, KindsOfQueries) {
  EXPECT_EQ(nearest({"--kind", "any", "--max-distance", "1"}, kThreePoints).out, "hit\n0\n1\n2\n");
  EXPECT_EQ(nearest({"--kind", "count", "--max-distance", "2"}, kThreePoints).out,
            "count\n1\n2\n4294967295\n");
  const std::string all =
      nearest({"--kind", "all", "--fields", "point,distance,primitive,x,hit"}, kThreePoints).out;
  EXPECT_TRUE(all.starts_with("point,distance,primitive,x,hit\n0,2,0,0.75,1\n0,2.0310096")) << all;
  EXPECT_EQ(nearest({"--kind", "all", "--max-hits", "1", "--fields", "point,primitive,x,hit"},
                    kThreePoints)
                .out,
            "point,primitive,x,hit\n0,0,0.75,3\n1,0,1,3\n2,0,nan,2\n");
}

TEST_F(NearestVerb, LinesOfJson) {
  EXPECT_EQ(nearest({"--out-format", "ndjson", "--fields", "distance,node,x,name,hit",
                     "--max-distance", "1.5"},
                    kThreePoints)
                .out,
            "{\"distance\":null,\"node\":0,\"x\":null,\"name\":\"\",\"hit\":0}\n"
            "{\"distance\":1,\"node\":2,\"x\":1,\"name\":\"square\",\"hit\":1}\n"
            "{\"distance\":null,\"node\":0,\"x\":null,\"name\":\"\",\"hit\":2}\n");
  EXPECT_EQ(nearest({"--out-format", "ndjson", "--kind", "any"},
                    "[0.75, 0.25, 2]\n{\"position\": [0,0,1], \"max\": 0.5}\n")
                .out,
            "{\"hit\":1}\n{\"hit\":0}\n");
}

TEST_F(NearestVerb, NormalsAndNames) {
  EXPECT_EQ(nearest({"--fields", "name,nz,ny,nx"}, "0.75 0.25 2\n").out,
            "nx,ny,nz,name\n0,0,1,square\n");
  EXPECT_EQ(nearest({"--kind", "all", "--fields", "name,primitive"}, "0.75 0.25 2\nnan 0 0\n").out,
            "primitive,name\n0,square\n1,square\n0,\n");
}

TEST_F(NearestVerb, PlyHasThePointsThatHaveAFace) {
  EXPECT_EQ(
      nearest({"--out", dir_.path("near.ply"), "--fields", "distance,x,node"}, kThreePoints).exit,
      0);
  const std::string file = dir_.read("near.ply");
  EXPECT_NE(file.find("\nelement vertex 2 "), std::string::npos) << file;
  EXPECT_NE(file.find("property double z\nproperty double distance\nproperty double node\n"
                      "property double nearest_x\nend_header\n"),
            std::string::npos)
      << file;
  const std::string data = file.substr(file.find("end_header\n") + 11);
  std::array<double, 12> numbers{};
  ASSERT_EQ(data.size(), sizeof(numbers));
  std::memcpy(numbers.data(), data.data(), data.size());
  EXPECT_EQ(numbers, (std::array<double, 12>{0.75, 0.25, 2, 2, 2, 0.75, 2, 0, 0, 1, 2, 1}));
  const ProgramOutcome again = run_program(
      {"nearest", "square", "--in", dir_.path("near.ply"), "--fields", "distance", "--no-header"});
  EXPECT_EQ(again.out, "2\n1\n");
}

TEST_F(NearestVerb, ArraysHaveFieldsOfTheirNames) {
  EXPECT_EQ(nearest({"--out", dir_.path("near.npz")}, kThreePoints).exit, 0);
  const std::string archive = dir_.read("near.npz");
  for (const char* name : {"distance.npy", "node.npy", "x.npy", "z.npy"})
    EXPECT_NE(archive.find(name), std::string::npos) << name;
  EXPECT_EQ(nearest({"--out", dir_.path("near.npy"), "--fields", "distance,z"}, kThreePoints).exit,
            0);
  EXPECT_NE(dir_.read("near.npy").find("[('distance', '<f8'), ('z', '<f8')]"), std::string::npos);
}

TEST_F(NearestVerb, ReportsPoints) {
  const ProgramOutcome outcome = nearest({"--out", dir_.path("n.csv"), "--json"}, kThreePoints);
  EXPECT_EQ(
      outcome.err,
      "sightline: warning: 1 of 3 points are invalid: 1 with a position that is not finite\n");
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report["points"], 3);
  EXPECT_EQ(report["hits"], 2);
  EXPECT_EQ(report["invalid_reasons"], (nlohmann::json{{"position_not_finite", 1}}));
  EXPECT_TRUE(report.contains("points_per_s"));
  EXPECT_FALSE(report.contains("rays"));
  const ProgramOutcome text = nearest({"--out", dir_.path("n.csv")}, "0 0 1\n");
  EXPECT_TRUE(text.out.starts_with("1 points, 1 with a face, 0 invalid at revision ")) << text.out;
  const ProgramOutcome quiet = nearest({"--out", dir_.path("n.csv"), "--quiet"}, kThreePoints);
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(NearestVerb, NodesAreNamed) {
  EXPECT_EQ(nearest({"--kind", "any", "--exclude", "square"}, kThreePoints).out, "hit\n0\n0\n2\n");
  EXPECT_EQ(nearest({"--kind", "any", "--under", "square"}, kThreePoints).out, "hit\n1\n1\n2\n");
  EXPECT_EQ(nearest({"--under", "sqare"}, kThreePoints).exit, 3);
}

TEST_F(NearestVerb, ErrorsPrintNoNames) {
  const ProgramOutcome wrong = nearest({}, "1 2\n");
  EXPECT_EQ(wrong.exit, 1);
  EXPECT_EQ(wrong.out, "");
  const ProgramOutcome unknown = run_program({"nearest", "none", "--in", dir_.path("points.txt")});
  EXPECT_EQ(unknown.exit, 3);
  EXPECT_EQ(unknown.out, "");
}

TEST_F(NearestVerb, WhatItDoesNotHaveIsAUsageError) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--cull", "back"},
                                               {"--fields", "t"},
                                               {"--fields", "point"},
                                               {"--kind", "any", "--fields", "distance"},
                                               {"--max-distance", "-1"},
                                               {"--max-distance", "nan"},
                                               {"--max-hits", "3"},
                                               {"--out-format", "ply"},
                                               {"--out", "near.ply", "--kind", "count"},
                                               {"--out", "near.npy", "--fields", "name"},
                                               {"--out", "near.xyz"},
                                               {"--json"}}) {
    const ProgramOutcome outcome = nearest(more, kThreePoints);
    EXPECT_EQ(outcome.exit, 2) << more[0] << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_EQ(run_program({"cast", "square", "--fields", "x", "--in", dir_.path("points.txt")}).exit,
            2)
      << "rays have no such column";
}

}  // namespace
}  // namespace sightline::tests
