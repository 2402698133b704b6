// The bytes of rows in each format.
#include "client/cli/files/hit_format.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "client/cli/files/zip.h"

namespace sightline::client::cli::files {
namespace {

struct HitAndMiss {
  std::array<double, 2> t{2, std::numeric_limits<double>::infinity()};
  std::array<std::uint64_t, 2> node{7, 0};
  std::array<double, 12> lines{1, 2, 3, 0, 0, -1, 1, 2, 3, 0, 0, 1};

  RowView view() const {
    RowView rows;
    rows.t = t;
    rows.node = node;
    rows.lines = lines;
    return rows;
  }
};

std::string formatted(HitFormat& format) {
  const HitAndMiss rows;
  std::string bytes;
  format.add(rows.view(), 2, bytes);
  return bytes;
}

const std::vector<HitColumn> kTAndNode{HitColumn::kT, HitColumn::kNode};

TEST(HitFormat, CsvMayLackItsNames) {
  const auto named = make_hit_format(Format::kCsv, {.columns = kTAndNode});
  EXPECT_EQ(named->header(0), "t,node\n");
  EXPECT_EQ(formatted(*named), "2,7\ninf,0\n");
  EXPECT_EQ(make_hit_format(Format::kCsv, {.columns = kTAndNode, .names = false})->header(0), "");
}

TEST(HitFormat, JsonHasNoInfinity) {
  EXPECT_EQ(formatted(*make_hit_format(Format::kNdjson, {.columns = kTAndNode})),
            "{\"t\":2,\"node\":7}\n{\"t\":null,\"node\":0}\n");
}

TEST(HitFormat, PlyLeavesMissesOut) {
  const auto ply = make_hit_format(Format::kPly, {.columns = kTAndNode});
  EXPECT_TRUE(ply->needs_lines());
  EXPECT_TRUE(ply->counts_rows());
  EXPECT_EQ(ply->header(1).size(), ply->header(1'000'000).size());
  EXPECT_EQ(formatted(*ply).size(), 5 * sizeof(double));
  const HitAndMiss rows;
  EXPECT_EQ(hit_point(rows.view(), 0), (std::array<double, 3>{1, 2, 1}));
}

TEST(HitFormat, PlyOfPointsHasTheAskedPoints) {
  const auto ply =
      make_hit_format(Format::kPly, {.columns = {HitColumn::kT}, .asked = RowKind::kPoints});
  EXPECT_NE(ply->header(1).find("property double distance\n"), std::string::npos);
  std::array<double, 4> numbers{};
  const std::string bytes = formatted(*ply);
  ASSERT_EQ(bytes.size(), sizeof(numbers));
  std::memcpy(numbers.data(), bytes.data(), sizeof(numbers));
  EXPECT_EQ(numbers, (std::array<double, 4>{1, 2, 3, 2}));
}

TEST(HitFormat, NamesAreQuotedWhereTheyMustBe) {
  const std::vector<std::uint32_t> name{0, 1, 2};
  RowView rows;
  rows.name = name;
  rows.names = {"door", "a \"b\", c", "two\nlines"};
  const HitFormatOptions options{.columns = {HitColumn::kName}, .asked = RowKind::kPoints};
  std::string csv, json;
  make_hit_format(Format::kCsv, options)->add(rows, 3, csv);
  EXPECT_EQ(csv, "door\n\"a \"\"b\"\", c\"\ntwo\\x0alines\n");
  make_hit_format(Format::kNdjson, options)->add(rows, 3, json);
  EXPECT_EQ(json,
            "{\"name\":\"door\"}\n{\"name\":\"a \\\"b\\\", c\"}\n"
            "{\"name\":\"two\\nlines\"}\n");
}

TEST(HitFormat, NpyHasTheShapeOfTheRays) {
  const auto npy = make_hit_format(Format::kNpy, {.columns = kTAndNode, .array_shape = {2, 1}});
  EXPECT_NE(npy->header(0).find("'shape': (2, 1)"), std::string::npos);
  EXPECT_EQ(formatted(*npy).size(), 32U);
}

TEST(HitFormat, NpzIsWrittenAtTheEnd) {
  const auto npz = make_hit_format(Format::kNpz, {.columns = kTAndNode});
  EXPECT_EQ(formatted(*npz), "");
  const auto archive = npz->finish();
  ASSERT_TRUE(archive);
  const auto files = unzip(std::as_bytes(std::span(*archive)));
  ASSERT_TRUE(files);
  EXPECT_EQ(files->size(), 2U);
  EXPECT_TRUE(files->contains("t.npy"));
}

}  // namespace
}  // namespace sightline::client::cli::files
