// Rows as JSON and as tables, medians, hashes, and the .npy file.
#include "tests/bench/verbs/report.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/bench/scenes/npy.h"
#include "tests/bench/verbs/hit_hash.h"

namespace sightline::bench {
namespace {

TEST(Report, MediansAndLeast) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  Row row;
  set_times(row, "build_ms", {5, 9, 7});
  EXPECT_EQ(row["build_ms"], 7);
  EXPECT_EQ(row["build_ms_min"], 5);
}

TEST(Report, OneObjectALineInOrder) {
  Row a, b;
  a["scene"] = "x";
  a["count"] = 3;
  b["scene"] = "y";
  EXPECT_EQ(to_json_lines({a, b}), "{\"scene\":\"x\",\"count\":3}\n{\"scene\":\"y\"}\n");
}

TEST(Report, TablesAreAligned) {
  Row a, b;
  a["scene"] = "bunny";
  a["count"] = 3;
  b["scene"] = "y";
  b["hits"] = 1234567;
  EXPECT_EQ(to_table({a, b}),
            "scene  bunny        y\n"
            "count      3        -\n"
            "hits       -  1234567\n");
}

TEST(Report, ManyRowsAreALineEach) {
  std::vector<Row> rows(kMostColumns + 1, Row{{"scene", "y"}, {"count", 12}});
  rows[0]["scene"] = "bunny";
  const std::string table = to_table(rows);
  EXPECT_TRUE(table.starts_with("scene  count\nbunny     12\ny         12\n")) << table;
}

TEST(Fingerprint, CoversEveryColumn) {
  const auto print = [](const accel::geometry::Hit& hit) {
    Fingerprint fingerprint;
    fingerprint.add_columns(hit);
    return fingerprint.value();
  };
  const accel::geometry::Hit miss;
  std::vector<accel::geometry::Hit> hits(8);
  hits[0].t = 1;
  hits[1].node = 1;
  hits[2].primitive = 1;
  hits[3].u = 1;
  hits[4].v = 1;
  hits[5].normal = {0, 1, 0};
  hits[6].state = accel::geometry::HitState::kHit;
  hits[7].u = -0.0f;
  for (const accel::geometry::Hit& hit : hits) EXPECT_NE(print(hit), print(miss));
  accel::geometry::Hit harder;
  harder.work = 7;
  EXPECT_EQ(print(harder), print(miss));
}

TEST(HitHash, CoversTheColumnsOfTheKind) {
  std::vector<accel::geometry::Hit> hits(3);
  hits[1].state = accel::geometry::HitState::kHit;
  hits[1].node = 5;
  std::vector<accel::geometry::Hit> other = hits;
  using scenegraph::QueryKind;
  other[1].t = 3;
  EXPECT_EQ(hit_hash(hits, QueryKind::kClosest), hit_hash(other, QueryKind::kClosest));
  other[1].primitive = 1;
  EXPECT_NE(hit_hash(hits, QueryKind::kClosest), hit_hash(other, QueryKind::kClosest));
  EXPECT_EQ(hit_hash(hits, QueryKind::kAny), hit_hash(other, QueryKind::kAny));
  other[2].state = accel::geometry::HitState::kInvalid;
  EXPECT_NE(hit_hash(hits, QueryKind::kAny), hit_hash(other, QueryKind::kAny));
  EXPECT_EQ(hit_hash({}, QueryKind::kAny), "cbf29ce484222325");
}

TEST(Npy, HoldsRowsOfEightDoubles) {
  const auto file = std::filesystem::path(testing::TempDir()) / "sightline_rays_test.npy";
  std::vector<accel::geometry::Ray> rays(3);
  rays[2].origin = {1, 2, 3};
  rays[2].direction = {4, 5, 6};
  rays[2].tmin = 7;
  ASSERT_TRUE(write_rays(file, rays).ok());
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::filesystem::remove(file);
  ASSERT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t header =
      static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ((10 + header) % 64, 0u);
  EXPECT_NE(bytes.find("'shape': (3, 8)"), std::string::npos);
  ASSERT_EQ(bytes.size(), 10 + header + 3 * 64);
  std::array<double, 8> last;
  std::memcpy(last.data(), bytes.data() + 10 + header + 128, sizeof(last));
  EXPECT_EQ(last, (std::array<double, 8>{1, 2, 3, 4, 5, 6, 7, accel::geometry::kInfinity}));
}

TEST(Npy, NamesTheFileThatCannotBeWritten) {
  const auto status = write_rays("/nonexistent/rays.npy", {});
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("/nonexistent/rays.npy"), std::string::npos);
}

TEST(Quantile, IsLinearBetweenValues) {
  EXPECT_EQ(quantile({3}, 0.99), 3);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0), 1);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 1), 4);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_NEAR(quantile({0, 10}, 0.99), 9.9, 1e-12);
}

}  // namespace
}  // namespace sightline::bench
