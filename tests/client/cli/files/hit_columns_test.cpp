// Names of columns.
#include "client/cli/files/hit_columns.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::cli::files {
namespace {

TEST(HitColumns, ComeInTheOrderOfFilesWhateverTheOrderAsked) {
  const auto columns = parse_hit_columns("nz,t,node");
  ASSERT_TRUE(columns);
  EXPECT_EQ(*columns, (std::vector{HitColumn::kT, HitColumn::kNode, HitColumn::kNz}));
}

TEST(HitColumns, AllAreTheContracts) {
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

TEST(HitColumns, EveryKindHasItsOwn) {
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

TEST(HitColumns, OtherWordsAreErrors) {
  for (const char* text : {"", "t,", "t,t", "T", "normal", " t"})
    EXPECT_FALSE(parse_hit_columns(text)) << text;
}

TEST(HitColumns, AskTheServerForNoMoreThanTheyNeed) {
  const HitFields fields = fields_for({HitColumn::kV, HitColumn::kNx});
  EXPECT_TRUE(fields.barycentric && fields.normal);
  EXPECT_FALSE(fields.t || fields.node || fields.primitive || fields.hit || fields.work);
}

}  // namespace
}  // namespace sightline::client::cli::files
