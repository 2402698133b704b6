// Names of columns.
#include "client/cli/hit_columns.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::cli {
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
}  // namespace sightline::client::cli
