// Columns of hits by name.
#include <gtest/gtest.h>

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

TEST(HitColumns, SidesAreOfTheNearestFacesOfPoints) {
  constexpr RowKind kPoints = RowKind::kPoints;
  const auto columns = parse_hit_columns("votes,hit,signed,name,inside", kPoints);
  ASSERT_TRUE(columns);
  EXPECT_EQ(*columns, (std::vector{HitColumn::kName, HitColumn::kSigned, HitColumn::kInside,
                                   HitColumn::kVotes, HitColumn::kHit}));
  EXPECT_EQ(info_of(HitColumn::kSigned).type, "<f8");
  EXPECT_EQ(info_of(HitColumn::kInside).type, "|u1");
  EXPECT_EQ(info_of(HitColumn::kVotes).type, "|u1");
  EXPECT_TRUE(check_columns(*columns, QueryKind::kClosest, kPoints));
  for (const QueryKind kind : {QueryKind::kAny, QueryKind::kCount, QueryKind::kAll}) {
    const Status checked = check_columns({HitColumn::kInside}, kind, kPoints);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().message, "this kind of query has no 'inside'");
  }
  for (const char* name : {"signed", "inside", "votes"}) EXPECT_FALSE(parse_hit_columns(name));
  const HitFields fields = fields_for({HitColumn::kSigned, HitColumn::kVotes});
  EXPECT_TRUE(fields.signed_distance && fields.votes);
  EXPECT_FALSE(fields.inside || fields.t);
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

}  // namespace

}  // namespace sightline::client::cli::files
