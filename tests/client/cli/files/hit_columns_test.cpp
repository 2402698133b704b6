// Columns of hits by name, and rows of a cast of all hits.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "client/cli/files/hit_columns.h"

namespace sightline::client::cli::files {
namespace {

TEST(HitColumns, AreInTheOrderOfFilesForAnyRequestedOrder) {
  const auto columns = parse_hit_columns("nz,t,node");
  ASSERT_TRUE(columns);
  EXPECT_EQ(*columns, (std::vector{HitColumn::kT, HitColumn::kNode, HitColumn::kNz}));
}

TEST(HitColumns, AllAreTheDocumentedColumns) {
  std::string types;
  for (const HitColumn column : all_closest_columns()) {
    types += std::string(info_of(column).name) + " " + std::string(info_of(column).type) + ", ";
  }
  EXPECT_EQ(types, "t <f8, node <u8, primitive <u4, u <f4, v <f4, nx <f4, ny <f4, nz <f4, ");
}

std::string names(const std::vector<HitColumn>& columns) {
  std::string text;
  for (const HitColumn column : columns) text += std::string(info_of(column).name) + " ";
  return text;
}

TEST(HitColumns, EveryKindHasItsColumns) {
  EXPECT_EQ(names(standard_columns(QueryKind::kClosest)), "t node primitive u v nx ny nz ");
  EXPECT_EQ(names(standard_columns(QueryKind::kAny)), "hit ");
  EXPECT_EQ(names(standard_columns(QueryKind::kCount)), "count ");
  EXPECT_EQ(names(standard_columns(QueryKind::kAll)), "ray t node primitive u v nx ny nz ");
  EXPECT_EQ(info_of(HitColumn::kRay).type, "<u8");
  EXPECT_EQ(info_of(HitColumn::kCount).type, "<u4");
  EXPECT_TRUE(check_columns({HitColumn::kRay, HitColumn::kWork}, QueryKind::kAll));
  EXPECT_FALSE(check_columns({HitColumn::kRay}, QueryKind::kClosest));
  EXPECT_FALSE(check_columns({HitColumn::kT}, QueryKind::kCount));
  EXPECT_FALSE(check_columns({HitColumn::kCount}, QueryKind::kAny));
}

TEST(HitColumns, PointsHaveTheirOwn) {
  constexpr RowKind kPoints = RowKind::kPoints;
  const auto names_of_points = [](const std::vector<HitColumn>& columns) {
    std::string text;
    for (const HitColumn column : columns) text += std::string(info_of(column, kPoints).name) + " ";
    return text;
  };
  EXPECT_EQ(names_of_points(standard_columns(QueryKind::kClosest, kPoints)),
            "distance node primitive u v x y z ");
  EXPECT_EQ(names_of_points(standard_columns(QueryKind::kAll, kPoints)),
            "point distance node primitive u v x y z ");
  EXPECT_EQ(names_of_points(standard_columns(QueryKind::kCount, kPoints)), "count ");
  const auto columns = parse_hit_columns("name,nx,z,distance", kPoints);
  ASSERT_TRUE(columns);
  EXPECT_EQ(names_of_points(*columns), "distance z nx name ");
  EXPECT_TRUE(check_columns(*columns, QueryKind::kAll, kPoints));
  EXPECT_FALSE(check_columns(*columns, QueryKind::kAny, kPoints));
  EXPECT_FALSE(parse_hit_columns("t", kPoints));
  EXPECT_FALSE(parse_hit_columns("x"));
  EXPECT_FALSE(parse_hit_columns("name"));
  const HitFields fields = fields_for(*columns);
  EXPECT_TRUE(fields.t && fields.position && fields.normal && fields.name);
}

TEST(HitColumns, UnknownNamesAreErrors) {
  for (const char* text : {"", "t,", "t,t", "T", "normal", " t"})
    EXPECT_FALSE(parse_hit_columns(text)) << text;
}

TEST(HitColumns, RequestOnlyTheFieldsThatTheyNeed) {
  const HitFields fields = fields_for({HitColumn::kV, HitColumn::kNx});
  EXPECT_TRUE(fields.barycentric && fields.normal);
  EXPECT_FALSE(fields.t || fields.node || fields.primitive || fields.hit || fields.work);
}

// Two hits, a miss, a bad ray, and one hit of a ray whose list was cut.
struct Answers {
  std::vector<std::uint32_t> offsets{0, 2, 2, 2, 3};
  std::vector<std::uint8_t> hit{1, 0, 2, kCutOff};
  std::vector<std::uint32_t> work{10, 11, 0, 13};
  std::vector<double> t{1, 2, 3};
  std::vector<std::uint64_t> node{4, 5, 6};
  std::vector<float> barycentric{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};

  HitView view() const {
    HitView hits;
    hits.offsets = offsets;
    hits.hit = hit;
    hits.work = work;
    hits.t = t;
    hits.node = node;
    hits.barycentric = barycentric;
    return hits;
  }
};

template <class T>
std::vector<T> copy(std::span<const T> rows) {
  return {rows.begin(), rows.end()};
}

TEST(HitRows, AreOneForEachHitAndOneForABadRay) {
  const Answers answers;
  HitRows rows;
  for (int twice = 0; twice < 2; ++twice) {
    const RowView view = rows.make(100, answers.view());
    ASSERT_EQ(rows.size(), 4U);
    EXPECT_EQ(copy(view.ray), (std::vector<std::uint64_t>{100, 100, 102, 103}));
    EXPECT_EQ(copy(view.node), (std::vector<std::uint64_t>{4, 5, 0, 6}));
    EXPECT_EQ(copy(view.hit), (std::vector<std::uint8_t>{1, 1, 2, 3}));
    EXPECT_EQ(copy(view.work), (std::vector<std::uint32_t>{10, 10, 0, 13}));
    EXPECT_EQ(view.t[1], 2);
    EXPECT_TRUE(std::isnan(view.t[2]));
    EXPECT_EQ(view.t[3], 3);
    EXPECT_EQ(view.barycentric[6], 0.5F);
  }
}

TEST(HitRows, HavePositionsAndNames) {
  const Answers answers;
  const std::vector<double> position{1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<std::uint32_t> name{1, 0, 1};
  HitView hits = answers.view();
  hits.position = position;
  hits.name = name;
  hits.names = {"", "door"};
  HitRows rows;
  const RowView view = rows.make(0, hits);
  EXPECT_EQ(view.position[5], 6);
  EXPECT_TRUE(std::isnan(view.position[6])) << "the bad ray's";
  EXPECT_EQ(view.position[9], 7);
  EXPECT_EQ(name_of(view, 0), "door");
  EXPECT_EQ(name_of(view, 1), "");
  EXPECT_EQ(name_of(view, 2), "");
  EXPECT_EQ(name_of(view, 3), "door");
}

TEST(HitRows, AreCountedWithoutColumnT) {
  const Answers answers;
  HitView hits;
  hits.offsets = answers.offsets;
  hits.hit = answers.hit;
  HitRows rows;
  const RowView view = rows.make(0, hits);
  EXPECT_EQ(rows.size(), 4U);
  EXPECT_EQ(view.ray[3], 3U);
  EXPECT_EQ(view.hit[3], kCutOff);
}

}  // namespace

}  // namespace sightline::client::cli::files
