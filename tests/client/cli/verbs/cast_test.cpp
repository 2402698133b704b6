// cast as a filter, as another program drives it, and every format of hits.
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

class CastFilter : public LiveProgram {
 protected:
  CastFilter() {
    EXPECT_EQ(run_program({"scene", "import", "square", dir_.write("s.obj", kSquareObj)}).exit, 0);
  }

  ProgramOutcome cast(const std::vector<std::string>& more, const std::string& rays) const {
    std::vector<std::string> words{"cast", "square", "--in", dir_.write("rays.txt", rays)};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
};

constexpr const char* kThreeRays = "0.75 0.25 2 0 0 -1\n9 9 9 0 0 1\n0 0 0 0 0 0\n";

TEST_F(CastFilter, AnswersEachRayBeforeTheNextComes) {
  Coprocess filter({"cast", "square", "--quiet"});
  filter.write("0.75 0.25 2 0 0 -1\n");
  EXPECT_EQ(filter.read_line(), "t,node,primitive,u,v,nx,ny,nz\n");
  EXPECT_EQ(filter.read_line(), "2,2,0,0.5,0.25,0,0,1\n");
  for (int i = 0; i < 20; ++i) {
    filter.write("0.75,0.25," + std::to_string(i + 1) + ",0,0,-1\n");
    EXPECT_EQ(filter.read_line(), std::to_string(i + 1) + ",2,0,0.5,0.25,0,0,1\n");
  }
  filter.write("9 9 9 0 0 1");
  filter.close_input();
  EXPECT_EQ(filter.read_line(), "inf,0,0,0,0,0,0,0\n") << "the last line may lack its end";
  EXPECT_EQ(filter.wait(), 0);
}

TEST_F(CastFilter, UpdatesOfAFileComeFirst) {
  const std::string ops =
      dir_.write("ops.ndjson",
                 R"({"set_transforms": {"nodes": [2], "matrices": [[1,0,0,0, 0,1,0,0, 0,0,1,1]]}}
{"put_node": {"node": -1, "name": "new"}}
)");
  const std::string hits = dir_.path("hits.csv");
  const ProgramOutcome done = cast({"--apply", ops, "--out", hits, "--json"}, kThreeRays);
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto json = nlohmann::json::parse(done.out);
  EXPECT_EQ(json["revision"], 2);
  EXPECT_EQ(json["nodes"], nlohmann::json::array({3}));
  EXPECT_NE(cast({}, kThreeRays).out.find("\n1,2,0,0.5,0.25,0,0,1\n"), std::string::npos);
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--apply", ops, "--revision", "1"},
        {"--apply", ops, "--at-least", "x"},
        {"--apply", dir_.write("bad.ndjson", "{}\n")},
        {"--apply", dir_.write("none.ndjson", R"({"delete_node": {"node": 99}})")}}) {
    const ProgramOutcome refused = cast(wrong, kThreeRays);
    EXPECT_NE(refused.exit, 0) << wrong[1];
    EXPECT_EQ(refused.out, "") << wrong[1];
  }
  // Rays that cannot be read leave the scene as it is.
  EXPECT_NE(run_program({"cast", "square", "--in", dir_.path("nowhere.csv"), "--apply", ops}).exit,
            0);
  EXPECT_EQ(
      nlohmann::json::parse(run_program({"scene", "show", "square", "--json"}).out)["revision"], 2);
}

TEST_F(CastFilter, WithoutRaysThereIsALineOfNames) {
  Coprocess filter({"cast", "square", "--quiet"});
  filter.close_input();
  EXPECT_EQ(filter.read_rest(), "t,node,primitive,u,v,nx,ny,nz\n");
  EXPECT_EQ(filter.wait(), 0);
}

TEST_F(CastFilter, AnErrorPrintsNoNames) {
  const ProgramOutcome outcome = cast({}, "1 2 3\n");
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(run_program({"cast", "none", "--in", dir_.path("rays.txt")}).out, "");
}

TEST_F(CastFilter, LinesOfJson) {
  EXPECT_EQ(cast({"--out-format", "ndjson", "--fields", "t,node,hit"}, kThreeRays).out,
            "{\"t\":2,\"node\":2,\"hit\":1}\n{\"t\":null,\"node\":0,\"hit\":0}\n"
            "{\"t\":null,\"node\":0,\"hit\":2}\n");
  EXPECT_EQ(cast({"--out-format", "ndjson", "--kind", "any"},
                 "[0.75, 0.25, 2, 0, 0, -1]\n{\"origin\": [9,9,9], \"direction\": [0,0,1]}\n")
                .out,
            "{\"hit\":1}\n{\"hit\":0}\n");
  EXPECT_EQ(cast({"--no-header", "--fields", "t"}, kThreeRays).out, "2\ninf\nnan\n");
}

TEST_F(CastFilter, PlyHasAPointForEachHit) {
  const std::string out = dir_.path("hits.ply");
  EXPECT_EQ(cast({"--out", out, "--fields", "node"}, kThreeRays).exit, 0);
  const std::string file = dir_.read("hits.ply");
  EXPECT_NE(file.find("\nelement vertex 1 "), std::string::npos) << file;
  EXPECT_NE(file.find("property double node\n"), std::string::npos)
      << "there are no 64-bit integers";
  const std::string data = file.substr(file.find("end_header\n") + 11);
  ASSERT_EQ(data.size(), 4 * sizeof(double));
  std::array<double, 4> numbers{};
  std::memcpy(numbers.data(), data.data(), data.size());
  EXPECT_EQ(numbers, (std::array<double, 4>{0.75, 0.25, 0, 2}));
}

TEST_F(CastFilter, NpzHasAnArrayForEachColumn) {
  const std::string out = dir_.path("hits.npz");
  EXPECT_EQ(cast({"--out", out}, kThreeRays).exit, 0);
  const std::string file = dir_.read("hits.npz");
  for (const char* name : {"t.npy", "node.npy", "primitive.npy", "u.npy", "nz.npy"})
    EXPECT_NE(file.find(name), std::string::npos) << name;
  EXPECT_NE(file.find("{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }"),
            std::string::npos);
}

TEST_F(CastFilter, SaysWhyRaysAreInvalid) {
  const ProgramOutcome outcome = cast({"--out", dir_.path("h.csv"), "--json"}, kThreeRays);
  EXPECT_EQ(outcome.err,
            "sightline: warning: 1 of 3 rays cannot be cast: 1 with a direction of zero\n");
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["invalid_reasons"],
            (nlohmann::json{{"direction_zero", 1}}));
  EXPECT_EQ(cast({"--out", dir_.path("h.csv"), "--quiet"}, kThreeRays).err, "");
}

TEST_F(CastFilter, NodesAreNamed) {
  EXPECT_EQ(cast({"--kind", "any", "--exclude", "square"}, kThreeRays).out, "hit\n0\n0\n2\n");
  EXPECT_EQ(cast({"--kind", "any", "--under", "square"}, kThreeRays).out, "hit\n1\n0\n2\n");
  const ProgramOutcome unknown = cast({"--under", "sqare"}, kThreeRays);
  EXPECT_EQ(unknown.exit, 3);
  EXPECT_EQ(unknown.err,
            "sightline: there is no node 'sqare', did you mean 'square'?; `sightline scene nodes "
            "SCENE` lists them\n");
}

TEST_F(CastFilter, ErrorsAreJsonOnRequest) {
  const ProgramOutcome outcome = run_program({"scene", "show", "sqare", "--json"});
  EXPECT_EQ(outcome.exit, 3);
  EXPECT_EQ(outcome.out, "");
  const auto error = nlohmann::json::parse(outcome.err)["error"];
  EXPECT_EQ(error["reason"], "SCENE_NOT_FOUND");
  EXPECT_EQ(error["hint"], "did you mean square?");
  EXPECT_EQ(error["exit"], 3);
  EXPECT_EQ(nlohmann::json::parse(run_program({"cats", "--json"}).err)["error"]["exit"], 2);
}

}  // namespace
}  // namespace sightline::tests
