// chart measures all configurations of its table, writes its files, and refuses wrong input.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "accel/published/any_builder.h"
#include "tests/bench/charts/configurations.h"
#include "tests/bench/charts/csv.h"
#include "tests/bench/charts/scenes.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

namespace fs = std::filesystem;

CommonOptions common() {
  CommonOptions options;
  options.threads = 2;
  options.repeat = 2;
  return options;
}

class ChartTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_chart_") + test->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

// Only for texts without commas or quotation marks.
std::vector<std::map<std::string, std::string>> read_csv(const fs::path& path) {
  std::ifstream file(path);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> found;
    std::istringstream rest(line);
    for (std::string cell; std::getline(rest, cell, ',');) found.push_back(cell);
    return found;
  };
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(file, line)) {
    const std::vector<std::string> values = cells(line);
    EXPECT_EQ(values.size(), names.size()) << line;
    rows.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
      if (!values[i].empty()) rows.back()[names[i]] = values[i];
    }
  }
  return rows;
}

TEST_F(ChartTest, MeasuresEveryConfigurationOverEveryScene) {
  const ChartOptions options{
      folder_.string(), {"gen:city?boxes=50", "gen:icosphere?level=2"}, true};
  const auto files = run_chart(common(), options);
  ASSERT_TRUE(files.ok()) << files.error().message;
  ASSERT_EQ(files->front()["file"], (folder_ / "speed_accuracy.csv").string());
  for (const Row& file : *files) EXPECT_GT(file["bytes"], 0) << file.dump();

  std::map<std::string, std::size_t> studies;
  std::map<std::string, std::set<std::string>> hashes;
  for (const auto& row : read_csv(folder_ / "speed_accuracy.csv")) {
    ++studies[row.at("study")];
    for (const char* key : {"scene", "builder", "threads", "machine", "compiler", "commit", "date"})
      EXPECT_TRUE(row.contains(key)) << key;
    if (row.at("study") == "trace" && !row.at("builder").starts_with("embree")) {
      hashes[row.at("scene") + row.at("rays")].insert(row.at("hit_hash"));
      EXPECT_GT(std::stod(row.at("work_per_ray")), 0);
      EXPECT_GT(std::stod(row.at("trace_over_sweep")), 0);
    }
    if (row.at("configuration") == kExactSweep && row.contains("work_over_sweep")) {
      EXPECT_EQ(row.at("work_over_sweep"), "1");
    }
  }
  const std::size_t contenders = chart_contenders().size();
  EXPECT_EQ(studies["build"], 2 * contenders);
  EXPECT_EQ(studies["trace"], 2 * 3 * contenders);
  EXPECT_EQ(studies["image"] % (2 * 2 * 4), 0u);  // scenes, views, 1 to 1,000 rays
  EXPECT_GT(studies["image"], 0u);
  EXPECT_EQ(hashes.size(), 6u);
  for (const auto& [what, found] : hashes) EXPECT_EQ(found.size(), 1u) << what;
}

// Without scenes, or with wrong ones, it fails before minutes of work.
TEST_F(ChartTest, RefusesWrongInput) {
  const auto refusal = [&](CommonOptions with, std::vector<std::string> scenes) {
    const auto done = run_chart(with, {folder_.string(), std::move(scenes), true});
    EXPECT_FALSE(done.ok());
    EXPECT_FALSE(fs::exists(folder_));
    return done.ok() ? Error{} : done.error();
  };
  ASSERT_EQ(unsetenv("SIGHTLINE_SCENES"), 0);
  const Error none = refusal(common(), {});
  EXPECT_EQ(none.code, Code::kInvalidArgument);
  EXPECT_NE(none.message.find("--scenes"), std::string::npos);
  EXPECT_NE(none.message.find("SIGHTLINE_SCENES"), std::string::npos);
  const std::string city = "gen:city?boxes=5";
  EXPECT_EQ(refusal(common(), {city, city}).code, Code::kInvalidArgument);
  EXPECT_EQ(refusal(common(), {city, "/nonexistent.ply"}).code, Code::kNotFound);
  EXPECT_EQ(refusal(common(), {city, "gen:nothing"}).code, Code::kInvalidArgument);
  CommonOptions odd = common();
  odd.set = {"samples=4"};
  EXPECT_EQ(refusal(odd, {city}).code, Code::kInvalidArgument);
  odd = common();
  odd.scene = city;
  EXPECT_EQ(refusal(odd, {}).code, Code::kInvalidArgument);
  odd = common();
  odd.policy = "full";
  EXPECT_EQ(refusal(odd, {city}).code, Code::kInvalidArgument);
}

TEST_F(ChartTest, AFileInsteadOfTheFolderIsRefused) {
  std::ofstream(folder_) << "in the way";
  const auto done = run_chart(common(), {folder_.string(), {"gen:city?boxes=5"}, true});
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, Code::kFailedPrecondition);
}

TEST(ChartConfigurations, AreUniqueAndIncludeEveryBuilderWithDefaults) {
  std::set<std::string> texts;
  std::map<std::string, int> usual;
  for (const ChartConfiguration& c : chart_configurations()) {
    EXPECT_TRUE(texts.insert(c.text).second) << c.text;
    EXPECT_TRUE(c.text.starts_with(c.builder));
    EXPECT_EQ(c.usual, c.text == c.builder) << c.text;
    usual[c.builder] += c.usual ? 1 : 0;
  }
  for (const auto& [builder, count] : usual) EXPECT_EQ(count, 1) << builder;
  EXPECT_TRUE(texts.contains(std::string(kExactSweep)));
  // Builders that compare every pair of bounds are for small scenes.
  for (const std::string_view name : accel::published::builder_names()) {
    const bool slow = name == "sah-naive" || name == "sah-sort";
    EXPECT_EQ(usual.contains(std::string(name)), !slow) << name;
  }
}

// Every builder of the table has the parameters that the table sets.
TEST(ChartConfigurations, AreAllValid) {
  std::set<std::string> found;
  for (const ChartContender& contender : chart_contenders()) {
    found.insert(contender.configuration.text);
  }
  for (const ChartConfiguration& c : chart_configurations()) {
    EXPECT_EQ(found.contains(c.text), !parse_embree(c.builder) || embree_found()) << c.text;
  }
}

TEST(ChartScenes, AreAlsoOneMeshInTheWorld) {
  const auto scenes = load_chart_scenes({"gen:city?boxes=120", "gen:icosphere?level=1"}, common());
  ASSERT_TRUE(scenes.ok()) << scenes.error().message;
  ASSERT_EQ(scenes->size(), 2u);
  const ChartScene& city = scenes->front();
  EXPECT_EQ(city.name, "gen:city?boxes=120");
  EXPECT_GT(city.scene.meshes.size(), 1u);
  ASSERT_EQ(city.mesh.meshes.size(), 1u);
  EXPECT_EQ(city.mesh.nodes.size(), 1u);
  EXPECT_EQ(city.mesh.unique_triangles(), city.scene.unique_triangles());
}

TEST(ChartCsv, QuotesTextsAndRejectsUnknownColumns) {
  Row row;
  row["study"] = "build";
  row["machine"] = "2 cores, \"fast\" ones";
  row["touches"] = 12;
  const auto text = chart_csv({row});
  ASSERT_TRUE(text.ok());
  EXPECT_NE(text->find("\"2 cores, \"\"fast\"\" ones\""), std::string::npos) << *text;
  EXPECT_TRUE(text->starts_with("study,scene,"));
  row["nonsense"] = 1;
  EXPECT_FALSE(chart_csv({row}).ok());
}

}  // namespace
}  // namespace sightline::bench
