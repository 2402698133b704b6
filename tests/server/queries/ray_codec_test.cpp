// Rays from columns.
#include "server/queries/ray_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace sightline::server::queries {
namespace {

template <class T>
std::string column(std::vector<T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

v1::Rays two_rays() {
  v1::Rays rays;
  rays.set_origins(column<float>({1, 2, 3, 4, 5, 6}));
  rays.set_directions(column<float>({0, 0, 1, 0, 1, 0}));
  return rays;
}

/// Decodes all rays into the vector.
Status decode_all(const v1::Rays& columns, std::vector<accel::geometry::Ray>& rays) {
  const auto count = count_rays(columns);
  if (!count) return count.error();
  rays.resize(*count);
  decode_rays(columns, 0, rays);
  return {};
}

TEST(DecodeRays, FillsDefaults) {
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_all(two_rays(), rays));
  ASSERT_EQ(rays.size(), 2u);
  EXPECT_EQ(rays[1].origin, (accel::geometry::Vec3d{4, 5, 6}));
  EXPECT_EQ(rays[1].direction, (accel::geometry::Vec3d{0, 1, 0}));
  EXPECT_EQ(rays[1].tmin, 0);
  EXPECT_EQ(rays[1].tmax, accel::geometry::kInfinity);
  EXPECT_EQ(rays[1].mask, accel::geometry::kAllMasks);
}

TEST(DecodeRays, ReadsDoublesAndEveryColumn) {
  v1::Rays columns;
  columns.set_float64(true);
  columns.set_origins(column<double>({0.1, 0.2, 0.3}));
  columns.set_directions(column<double>({1, 0, 0}));
  columns.set_tmin(column<double>({-1}));
  columns.set_tmax(column<double>({1e300}));
  columns.set_masks(column<std::uint32_t>({6}));
  std::vector<accel::geometry::Ray> rays(7);
  ASSERT_TRUE(decode_all(columns, rays));
  ASSERT_EQ(rays.size(), 1u);
  EXPECT_EQ(rays[0].origin, (accel::geometry::Vec3d{0.1, 0.2, 0.3}));
  EXPECT_EQ(rays[0].tmin, -1);
  EXPECT_EQ(rays[0].tmax, 1e300);
  EXPECT_EQ(rays[0].mask, 6u);
}

TEST(DecodeRays, PassesNanToTheTracer) {
  v1::Rays columns = two_rays();
  columns.set_tmin(column<float>({std::numeric_limits<float>::quiet_NaN(), 0}));
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_all(columns, rays));
  EXPECT_TRUE(std::isnan(rays[0].tmin));
}

TEST(DecodeRays, KeepsNothingOfTheBatchBefore) {
  v1::Rays columns = two_rays();
  columns.set_masks(column<std::uint32_t>({1, 2}));
  std::vector<accel::geometry::Ray> rays;
  ASSERT_TRUE(decode_all(columns, rays));
  ASSERT_TRUE(decode_all(two_rays(), rays));
  EXPECT_EQ(rays[0].mask, accel::geometry::kAllMasks);
}

TEST(DecodeRays, NamesTheColumnItsBytesAndTheExpectedBytes) {
  const auto message_with = [](auto edit) {
    v1::Rays columns = two_rays();
    edit(columns);
    std::vector<accel::geometry::Ray> rays;
    const Status status = decode_all(columns, rays);
    EXPECT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::kInvalidArgument);
    return status.error().message;
  };
  const auto origins = message_with([](v1::Rays& r) { r.set_origins(std::string(25, '\0')); });
  EXPECT_NE(origins.find("origins has 25 bytes, expected a multiple of 12"), std::string::npos)
      << origins;
  const auto directions =
      message_with([](v1::Rays& r) { r.set_directions(std::string(12, '\0')); });
  EXPECT_NE(directions.find("directions has 12 bytes, expected 24"), std::string::npos)
      << directions;
  const auto tmin = message_with([](v1::Rays& r) { r.set_tmin(std::string(4, '\0')); });
  EXPECT_NE(tmin.find("tmin has 4 bytes, expected 8"), std::string::npos) << tmin;
  const auto tmax = message_with([](v1::Rays& r) { r.set_tmax(std::string(16, '\0')); });
  EXPECT_NE(tmax.find("tmax has 16 bytes, expected 8"), std::string::npos) << tmax;
  const auto masks = message_with([](v1::Rays& r) { r.set_masks(std::string(7, '\0')); });
  EXPECT_NE(masks.find("masks has 7 bytes, expected 8"), std::string::npos) << masks;
}

TEST(DecodeRays, ACountMustBeThatOfTheBytes) {
  v1::Rays columns = two_rays();
  std::vector<accel::geometry::Ray> rays;
  columns.set_count(2);
  EXPECT_TRUE(decode_all(columns, rays));
  columns.set_float64(true);
  const Status halved = decode_all(columns, rays);
  ASSERT_FALSE(halved);
  EXPECT_EQ(halved.error().code, Code::kInvalidArgument);
  EXPECT_EQ(halved.error().reason, "RAY_COUNT");
  EXPECT_EQ(halved.error().message,
            "count says 2 rays, but the 24 bytes of column origins hold 1, of 3 float64 each");
  columns.set_float64(false);
  for (const std::uint64_t other : {std::uint64_t{1}, std::uint64_t{3}, ~std::uint64_t{0}}) {
    columns.set_count(other);
    EXPECT_EQ(decode_all(columns, rays).error().reason, "RAY_COUNT") << other;
  }
  columns.Clear();
  columns.set_count(1);
  EXPECT_EQ(decode_all(columns, rays).error().reason, "RAY_COUNT");
}

TEST(DecodeRays, AcceptsTheLimitAndNoMore) {
  v1::Rays columns;
  columns.set_origins(std::string(kMaxRaysPerRequest * 12, '\0'));
  columns.set_directions(std::string(kMaxRaysPerRequest * 12, '\0'));
  std::vector<accel::geometry::Ray> rays;
  EXPECT_TRUE(decode_all(columns, rays));
  columns.mutable_origins()->append(12, '\0');
  columns.mutable_directions()->append(12, '\0');
  const Status status = decode_all(columns, rays);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::kResourceExhausted);
  EXPECT_NE(status.error().message.find("16385 rays, the limit is 16384"), std::string::npos);
}

TEST(DecodeRays, ABatchMayBeEmpty) {
  std::vector<accel::geometry::Ray> rays(3);
  ASSERT_TRUE(decode_all({}, rays));
  EXPECT_TRUE(rays.empty());
}

TEST(DecodeRays, DecodesSlices) {
  v1::Rays columns;
  std::vector<float> origins, directions, tmin, tmax;
  std::vector<std::uint32_t> masks;
  for (int i = 0; i < 10; ++i) {
    const auto x = static_cast<float>(i);
    origins.insert(origins.end(), {x, 0, 0});
    directions.insert(directions.end(), {0, x, 1});
    tmin.push_back(x);
    tmax.push_back(2 * x);
    masks.push_back(static_cast<std::uint32_t>(i));
  }
  columns.set_origins(column(origins));
  columns.set_directions(column(directions));
  columns.set_tmin(column(tmin));
  columns.set_tmax(column(tmax));
  columns.set_masks(column(masks));
  std::vector<accel::geometry::Ray> rays(3);
  decode_rays(columns, 7, rays);
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = 7.0 + static_cast<double>(i);
    EXPECT_EQ(rays[i].origin, (accel::geometry::Vec3d{x, 0, 0}));
    EXPECT_EQ(rays[i].direction, (accel::geometry::Vec3d{0, x, 1}));
    EXPECT_EQ(rays[i].tmin, x);
    EXPECT_EQ(rays[i].tmax, 2 * x);
    EXPECT_EQ(rays[i].mask, 7 + i);
  }
}

}  // namespace
}  // namespace sightline::server::queries
