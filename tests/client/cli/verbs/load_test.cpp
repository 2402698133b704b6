// sightline load: exit codes, JSON keys, the report, and the check against an earlier run.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "client/cli/terminal.h"
#include "tests/client/support/run_program.h"

namespace sightline::client::cli::verbs {
namespace {

using nlohmann::json;
using tests::run_program;

/// Two triangles for each square of a bent sheet.
std::string sheet(int side) {
  std::string text;
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x)
      text += "v " + std::to_string(x) + " " + std::to_string(x * y % 7) + " " + std::to_string(y) +
              "\n";
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int a = y * (side + 1) + x + 1, b = a + side + 1;
      text +=
          "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(b + 1) + "\n";
      text += "f " + std::to_string(a) + " " + std::to_string(b + 1) + " " + std::to_string(a + 1) +
              "\n";
    }
  }
  return text;
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Load : public tests::LiveProgram {
 protected:
  Load() {
    const auto imported =
        run_program({"scene", "import", "sheet", dir_.write("sheet.obj", sheet(20))});
    EXPECT_EQ(imported.exit, kOk) << imported.err;
  }

  static json load(std::vector<std::string> flags, int exit = kOk) {
    flags.insert(flags.begin(), {"load", "sheet", "--json"});
    const auto outcome = run_program(flags);
    EXPECT_EQ(outcome.exit, exit) << outcome.err;
    const json document = json::parse(outcome.out, nullptr, false);
    EXPECT_FALSE(document.is_discarded()) << outcome.out;
    return document;
  }
};

TEST_F(Load, RowsHaveTheKeysThatScriptsRead) {
  const json document = load(
      {"--compare", "lazy,full,none", "--coverage", "10,100", "--count", "20000", "--repeat", "1"});
  ASSERT_EQ(document["rows"].size(), 6u);
  for (const json& row : document["rows"]) {
    for (const char* key :
         {"build", "coverage", "rays_per_s", "p50_ms", "p90_ms", "p99_ms", "p999_ms", "max_ms",
          "first_hit_s", "last_hit_s", "failed", "refused", "triangles_built", "bytes_trees",
          "build_share", "queue_share", "trace_share", "client_cpu_share", "growth"})
      EXPECT_TRUE(row.contains(key)) << key;
    EXPECT_GE(row["rays"], 20'000);
    EXPECT_EQ(row["failed"], 0);
    EXPECT_GT(row["rays_per_s"], 0);
    EXPECT_LE(row["p50_ms"], row["p99_ms"]);
    EXPECT_LE(row["first_hit_s"], row["last_hit_s"]);
  }
  EXPECT_EQ(document["rows"][0]["build"], "lazy");
  EXPECT_EQ(document["rows"][0]["coverage"], 10.0);
  EXPECT_EQ(document["rows"][1]["build"], "full");
  EXPECT_EQ(document["rows"][1]["triangles_built"], 800);
  EXPECT_EQ(document["rows"][2]["triangles_built"], 0) << "none builds nothing, also after full";
}

TEST_F(Load, AWarmRunTakesItsTimeAndMixesUpdatesIn) {
  const json document =
      load({"--seconds", "1", "--updates", "0.2", "--batch", "64", "--rays", "random"});
  ASSERT_EQ(document["rows"].size(), 1u);
  const json& row = document["rows"][0];
  EXPECT_EQ(row["build"], "policy");
  EXPECT_GT(row["requests"], 0);
  EXPECT_GT(row["updates"], 0);
  EXPECT_EQ(row["updates_failed"], 0);
  EXPECT_EQ(document["clients"], 4);
  const json shown = json::parse(run_program({"scene", "show", "sheet", "--json"}).out);
  EXPECT_EQ(shown["instances"], 1) << "what the updates moved is gone";
}

TEST_F(Load, AnOpenLoopKeepsItsRate) {
  const json document =
      load({"--rate", "100", "--seconds", "0.5", "--batch", "16", "--kind", "any"});
  const json& row = document["rows"][0];
  EXPECT_EQ(document["clients"], nullptr);
  EXPECT_EQ(row["requests"], 50);
  EXPECT_EQ(row["rays"], 800);
}

TEST_F(Load, CastsTheRaysOfAFile) {
  const std::string rays =
      dir_.write("rays.csv", "5,99,5,0,-1,0\n6,99,6,0,-1,0\n900,99,6,0,-1,0\n");
  for (const char* kind : {"closest", "any", "count", "all"}) {
    const json row = load({"--rays", rays, "--kind", kind, "--seconds", "0.05"})["rows"][0];
    EXPECT_EQ(row["rays"].get<int>() % 3, 0);
    EXPECT_EQ(row["hits"].get<int>() * 3, row["rays"].get<int>() * 2);
  }
}

TEST_F(Load, WritesAPage) {
  const std::string file = dir_.path("report.html");
  load({"--compare", "lazy,full", "--coverage", "1,100", "--count", "20000", "--repeat", "1",
        "--report", file});
  const std::string page = text_of(file);
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_NE(page.find("Lazy against full"), std::string::npos);
  EXPECT_NE(page.find("--compare lazy,full"), std::string::npos);
}

TEST_F(Load, TheCheckFailsIfTheOldResultWasFaster) {
  const std::vector<std::string> flags{"--seconds", "0.1", "--batch", "64"};
  json old = load(flags);
  const auto check = [&](int exit) {
    auto with_check = flags;
    with_check.insert(with_check.end(),
                      {"--check", dir_.write("old.json", old.dump()), "--tolerance", "0.5"});
    return load(with_check, exit);
  };
  json& row = old["rows"][0];
  row["rays_per_s"] = 0;
  for (const char* figure : {"p50_ms", "p99_ms"}) row[figure] = 1e9;
  EXPECT_TRUE(check(kOk)["regressions"].empty());
  row["rays_per_s"] = 1e15;
  EXPECT_EQ(check(kFailed)["regressions"].size(), 1u);
}

TEST_F(Load, WhatCannotBeComparedIsAnError) {
  const auto outcome = [&](const std::string& old) {
    return run_program({"load", "sheet", "--seconds", "0.05", "--check", old});
  };
  EXPECT_EQ(outcome(dir_.path("missing.json")).exit, kFailed);
  EXPECT_EQ(outcome(dir_.write("text.json", "fast")).exit, kFailed);
  EXPECT_EQ(outcome(dir_.write("other.json", "{\"rows\": []}")).exit, kFailed);
}

TEST_F(Load, WrongFlagsAreUsageErrors) {
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"--clients", "2", "--rate", "3"},
                                             {"--clients", "0"},
                                             {"--rate", "0"},
                                             {"--batch", "99999"},
                                             {"--updates", "2"},
                                             {"--compare", "best"},
                                             {"--coverage", "0"},
                                             {"--coverage", "10,200"},
                                             {"--count", "5"},
                                             {"--tolerance", "0.1"},
                                             {"--kind", "nearest"}}) {
    std::vector<std::string> words{"load", "sheet"};
    words.insert(words.end(), flags.begin(), flags.end());
    EXPECT_EQ(run_program(words).exit, kUsage) << flags.front() << " " << flags[1];
  }
  EXPECT_EQ(run_program({"load", "nothing"}).exit, kNotFound);
  EXPECT_EQ(run_program({"load", "sheet", "--rays", "missing.npy"}).exit, kFailed);
}

}  // namespace
}  // namespace sightline::client::cli::verbs
