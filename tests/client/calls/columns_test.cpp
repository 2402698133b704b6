// Columns of different lengths, and copies of rows.
#include "client/calls/columns.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace sightline::client::calls {
namespace {

const std::vector<double> kSix{1, 2, 3, 4, 5, 6};
const std::vector<double> kTwo{7, 8};

TEST(Columns, LengthsMustAgree) {
  const RayColumns<const double> rays{kSix, kSix};
  std::vector<double> t(2);
  std::vector<float> normal(5);
  EXPECT_TRUE(check_rows(rays, HitColumns{.t = t}));
  const Status bad_normal = check_rows(rays, HitColumns{.t = t, .normal = normal});
  ASSERT_FALSE(bad_normal);
  EXPECT_EQ(bad_normal.error().message, "normal holds 5 values, but 2 rays need 6");
  const Status bad_rays = check_rows(RayColumns<const double>{kSix, kTwo}, HitColumns{});
  ASSERT_FALSE(bad_rays);
  EXPECT_EQ(bad_rays.error().code, Code::kInvalidArgument);
  EXPECT_FALSE(check_rows(RayColumns<const double>{kTwo, kTwo}, HitColumns{}));
  EXPECT_FALSE(check_rows(
      RayColumns<const double>{.origins = kSix, .directions = kSix, .tmin = kSix}, HitColumns{}));
}

TEST(Columns, AnOmittedBoundIsFilledIn) {
  std::vector<double> origins(3), directions(3), tmin(1), tmax(1);
  const RayColumns<double> buffer{origins, directions, tmin, tmax};
  const RayColumns<const double> with_tmin{.origins = kSix, .directions = kSix, .tmin = kTwo};
  copy_part(with_tmin, 1, buffer);
  EXPECT_EQ(origins, (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(tmin[0], 8);
  EXPECT_EQ(tmax[0], std::numeric_limits<double>::infinity());
  EXPECT_TRUE(shape_of(with_tmin).interval);
  EXPECT_FALSE(shape_of(RayColumns<const double>{kSix, kSix}).interval);
}

TEST(Columns, PointsAreCopiedPartByPart) {
  const std::vector<std::uint32_t> masks{3, 4};
  const PointColumns<const double> points{kSix, kTwo, masks};
  EXPECT_TRUE(shape_of(points).max_distance && shape_of(points).masks);
  std::vector<double> positions(9), most(3);
  std::vector<std::uint32_t> copied(3);
  const auto source = source_of(points);
  EXPECT_EQ(*source({positions, most, copied}), 2U);
  EXPECT_EQ(positions[5], 6);
  EXPECT_EQ(most, (std::vector<double>{7, 8, 0}));
  EXPECT_EQ(copied, (std::vector<std::uint32_t>{3, 4, 0}));
  EXPECT_EQ(*source({positions, most, copied}), 0U);
  EXPECT_FALSE(check_rows(PointColumns<const double>{kTwo}, HitColumns{}));
  EXPECT_EQ(check_rows(PointColumns<const double>{kSix, kSix}, HitColumns{}).error().message,
            "max_distance holds 6 values, but 2 points need 2");
}

TEST(Columns, HitsAreCopiedToTheirRows) {
  const std::vector<float> two_normals{1, 2, 3, 4, 5, 6};
  std::vector<float> normals(12);
  HitView answers;
  answers.normal = two_normals;
  copy_hits(answers, 1, HitColumns{.normal = normals});
  EXPECT_EQ(normals, (std::vector<float>{0, 0, 0, 1, 2, 3, 4, 5, 6, 0, 0, 0}));
}

TEST(Columns, NamesAreCopiedFromTheirRows) {
  const std::vector<std::uint32_t> rows{2, 0, 1};
  std::vector<std::string> names(4, "before");
  HitView answers;
  answers.name = rows;
  answers.names = {"", "door", "wall"};
  copy_hits(answers, 1, HitColumns{.name = names});
  EXPECT_EQ(names, (std::vector<std::string>{"before", "wall", "", "door"}));
  AllHits all;
  all.append(answers);
  all.append(answers);
  EXPECT_EQ(all.name, (std::vector<std::string>{"wall", "", "door", "wall", "", "door"}));
}

}  // namespace
}  // namespace sightline::client::calls
