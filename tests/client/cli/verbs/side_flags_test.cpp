// The sides of points, from the command line to files of every format.
#include "client/cli/verbs/side_flags.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/support/boxes.h"
#include "tests/client/support/run_program.h"

namespace sightline::tests {
namespace {

constexpr const char* kPoints = "1.5 1.5 1.5\n0.5 0.5 0.5\n4 2.5 2.5\nnan 0 0\n";
const std::vector<std::string> kSides{"--fields", "signed,inside,votes"};

class SideFlags : public LiveProgram {
 protected:
  // Two boxes that overlap from 1 to 2.
  SideFlags() {
    const std::string obj =
        obj_of({mesh_of({{0, 0, 0}, {2, 2, 2}}), mesh_of({{1, 1, 1}, {3, 3, 3}})});
    EXPECT_EQ(run_program({"scene", "import", "boxes", dir_.write("boxes.obj", obj)}).exit, 0);
  }

  ProgramOutcome ask(std::vector<std::string> more, const std::string& points = kPoints) const {
    std::vector<std::string> words{"nearest", "boxes", "--in", dir_.write("points.txt", points)};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  ProgramOutcome sides(std::vector<std::string> more, const std::string& points = kPoints) const {
    more.insert(more.end(), kSides.begin(), kSides.end());
    return ask(more, points);
  }

  // The bytes behind the header of a file that has been written.
  std::string data_of(const std::string& file, const std::string& end) const {
    const std::string bytes = dir_.read(file);
    return bytes.substr(bytes.find(end) + end.size());
  }
};

TEST_F(SideFlags, LinesOfText) {
  EXPECT_EQ(sides({}).out, "signed,inside,votes\n0.5,0,0\n-0.5,1,1\n1,0,0\nnan,2,0\n");
  EXPECT_EQ(sides({"--side", "winding", "--side-rays", "3"}).out,
            "signed,inside,votes\n-0.5,1,3\n-0.5,1,3\n1,0,0\nnan,2,0\n");
  EXPECT_EQ(
      ask({"--side", "normal", "--fields", "inside,distance"}, "4 2.5 2.5\n2.75 2.5 2.5\n").out,
      "distance,inside\n1,0\n0.25,1\n");
  EXPECT_EQ(sides({"--max-distance", "0.25"}).out,
            "signed,inside,votes\ninf,0,0\ninf,1,1\ninf,0,0\nnan,2,0\n")
      << "sides do not depend on the distance";
}

TEST_F(SideFlags, LinesOfJson) {
  EXPECT_EQ(sides({"--out-format", "ndjson", "--side", "winding"}).out,
            "{\"signed\":-0.5,\"inside\":1,\"votes\":1}\n"
            "{\"signed\":-0.5,\"inside\":1,\"votes\":1}\n"
            "{\"signed\":1,\"inside\":0,\"votes\":0}\n"
            "{\"signed\":null,\"inside\":2,\"votes\":0}\n");
}

TEST_F(SideFlags, ArraysHaveFieldsOfTheirTypes) {
  EXPECT_EQ(sides({"--out", dir_.path("s.npy")}).exit, 0);
  EXPECT_NE(dir_.read("s.npy").find("[('signed', '<f8'), ('inside', '|u1'), ('votes', '|u1')]"),
            std::string::npos);
  const std::string rows = data_of("s.npy", "\n");
  ASSERT_EQ(rows.size(), 4U * 10);
  double distance = 0;
  std::memcpy(&distance, rows.data() + 10, sizeof(distance));
  EXPECT_EQ(distance, -0.5);
  EXPECT_EQ(rows[18], 1);
  EXPECT_EQ(rows[38], 2);
  EXPECT_EQ(sides({"--out", dir_.path("s.npz")}).exit, 0);
  for (const char* name : {"signed.npy", "inside.npy", "votes.npy"})
    EXPECT_NE(dir_.read("s.npz").find(name), std::string::npos) << name;
}

TEST_F(SideFlags, PlyHasThemAsProperties) {
  EXPECT_EQ(sides({"--out", dir_.path("s.ply"), "--side", "winding"}).exit, 0);
  EXPECT_NE(dir_.read("s.ply").find("property double signed\nproperty uchar inside\n"
                                    "property uchar votes\nend_header\n"),
            std::string::npos);
  const std::string rows = data_of("s.ply", "end_header\n");
  ASSERT_EQ(rows.size(), 3U * 34) << "the invalid point has no vertex";
  std::array<double, 4> first{};
  std::memcpy(first.data(), rows.data(), sizeof(first));
  EXPECT_EQ(first, (std::array<double, 4>{1.5, 1.5, 1.5, -0.5}));
  EXPECT_EQ(rows[32], 1);
  EXPECT_EQ(ask({"--out", dir_.path("i.ply"), "--fields", "inside"}).exit, 0);
  EXPECT_EQ(data_of("i.ply", "end_header\n").size(), 3U * 25);
}

TEST_F(SideFlags, TheSummaryCountsWhatIsInside) {
  const std::string out = dir_.path("s.csv");
  const auto report = nlohmann::json::parse(sides({"--out", out, "--json"}).out);
  EXPECT_EQ(report["inside"], 1);
  EXPECT_EQ(report["points"], 4);
  EXPECT_EQ(
      nlohmann::json::parse(sides({"--out", out, "--json", "--side", "winding"}).out)["inside"], 2);
  EXPECT_TRUE(
      sides({"--out", out}).out.starts_with("4 points, 3 with a face, 1 inside, 1 invalid"));
  const ProgramOutcome alone = ask({"--out", out, "--fields", "inside"});
  EXPECT_TRUE(alone.out.starts_with("4 points, 1 inside, 1 invalid at revision ")) << alone.out;
  EXPECT_TRUE(nlohmann::json::parse(ask({"--out", out, "--fields", "votes", "--json"}).out)["hits"]
                  .is_null());
  const auto without = nlohmann::json::parse(ask({"--out", out, "--json"}).out);
  EXPECT_FALSE(without.contains("inside"));
}

TEST_F(SideFlags, WhatCannotBeAskedIsAUsageError) {
  struct Case {
    std::vector<std::string> more;
    const char* text;
  };
  for (const Case& wrong : {
           Case{{"--side", "parity"},
                "--side: it is for signed, inside and votes: name one of them in --fields"},
           Case{{"--side-rays", "3", "--fields", "distance"},
                "--side-rays: it is for signed, inside and votes: name one of them in --fields"},
           Case{{"--fields", "signed", "--side-rays", "4"},
                "--side-rays: '4' is not an odd number from 1 to 63"},
           Case{{"--fields", "signed", "--side-rays", "65"},
                "--side-rays: '65' is not an odd number from 1 to 63"},
           Case{{"--fields", "signed", "--side-rays", "0"},
                "--side-rays: '0' is not an odd number from 1 to 63"},
           Case{{"--fields", "signed", "--side-rays", "2.5"},
                "--side-rays: '2.5' is not an odd number from 1 to 63"},
           Case{{"--fields", "signed", "--side", "odd"}, "--side is 'odd', not one of "},
           Case{{"--fields", "signed", "--side", "normal", "--side-rays", "3"},
                "--side-rays: 3 with --side normal, which casts no rays"},
           Case{{"--fields", "votes", "--side", "normal"},
                "--fields: votes are of rays, and --side normal casts none"},
           Case{{"--fields", "inside", "--kind", "all"},
                "--fields: this kind of query has no 'inside'"},
       }) {
    const ProgramOutcome outcome = ask(wrong.more);
    EXPECT_EQ(outcome.exit, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find(wrong.text), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(run_program({"cast", "boxes", "--side", "parity"}).exit, 2) << "rays have no sides";
}

}  // namespace
}  // namespace sightline::tests
