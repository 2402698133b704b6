// Why rays cannot be cast, judged as the server does.
#include "client/cli/verbs/ray_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::cli::verbs {
namespace {

constexpr double kBeyond = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

struct WatchedCase {
  std::array<double, 3> origin;
  std::array<double, 3> direction;
  double tmin;
  double tmax;
  RayFault fault;
};

const std::vector<WatchedCase> kWatchedCases{
    {{0, 0, 1}, {0, 0, -1}, 0, kBeyond, RayFault::kNone},
    {{0, kNotANumber, 1}, {0, 0, -1}, 0, kBeyond, RayFault::kOriginNotFinite},
    {{0, 0, 1}, {0, kBeyond, -1}, 0, kBeyond, RayFault::kDirectionNotFinite},
    {{0, 0, 1}, {0, -0.0, 0}, 0, kBeyond, RayFault::kDirectionZero},
    {{0, 0, 1}, {0, 0, -1}, kNotANumber, kBeyond, RayFault::kBoundNan},
    {{0, 0, 1}, {0, 0, -1}, 0, kNotANumber, RayFault::kBoundNan},
    {{0, 0, 1}, {0, 0, -1}, -kBeyond, kBeyond, RayFault::kNone},
    {{0, 0x1p250, 1}, {0, 0, -1}, 0, kBeyond, RayFault::kNone},
    {{0, 0x1.001p250, 1}, {0, 0, -1}, 0, kBeyond, RayFault::kOriginTooFar},
    {{0, 0, 1}, {0, 0, 0x1p-1000}, 0, kBeyond, RayFault::kNone},
    {{0, 0, 1}, {0, 0, 0x1p-1001}, 0, kBeyond, RayFault::kDirectionOutOfRange},
    {{0, 0, 1}, {0, 0, 0x1.fp1000}, 0, kBeyond, RayFault::kNone},
    {{0, 0, 1}, {0, 0, 0x1p1001}, 0, kBeyond, RayFault::kDirectionOutOfRange}};

TEST(RayWatch, JudgesEachFault) {
  for (const WatchedCase& c : kWatchedCases) {
    EXPECT_EQ(fault_of(c.origin.data(), c.direction.data(), c.tmin, c.tmax), c.fault)
        << info_of(c.fault).key << c.origin[1] << " " << c.direction[2];
  }
}

TEST(RayWatch, CountsFaultsAndKeepsRaysUntilTheyAreForgotten) {
  std::size_t next = 0;
  const RaySource<double> source = [&](const RayColumns<double>& buffer) -> Result<std::size_t> {
    const std::size_t n = std::min(buffer.size(), kWatchedCases.size() - next);
    for (std::size_t i = 0; i < n; ++i, ++next) {
      for (std::size_t k = 0; k < 3; ++k) {
        buffer.origins[3 * i + k] = kWatchedCases[next].origin[k];
        buffer.directions[3 * i + k] = kWatchedCases[next].direction[k];
      }
      buffer.tmin[i] = kWatchedCases[next].tmin;
      buffer.tmax[i] = kWatchedCases[next].tmax;
    }
    return n;
  };
  RayWatch watch;
  RaysOnTheirWay rays;
  watch.on_their_way = &rays;
  const auto watching = watched(source, watch);
  std::vector<double> origins(3 * 20), directions(3 * 20), tmin(20), tmax(20);
  ASSERT_EQ(*watching({origins, directions, tmin, tmax}), kWatchedCases.size());
  EXPECT_EQ(watch.faults[static_cast<std::size_t>(RayFault::kNone)], 5U);
  EXPECT_EQ(watch.faults[static_cast<std::size_t>(RayFault::kBoundNan)], 2U);
  rays.forget_before(2);
  EXPECT_EQ(rays.at(2).direction[1], kBeyond);
  EXPECT_EQ(rays.at(12).direction[2], 0x1p1001);
}

struct WatchedPoint {
  std::array<double, 3> position;
  double max;
  RayFault fault;
};

const std::vector<WatchedPoint> kWatchedPoints{
    {{0, 0, 1}, kBeyond, RayFault::kNone},
    {{0, 0, 1}, -1, RayFault::kNone},
    {{0, kNotANumber, 1}, kBeyond, RayFault::kOriginNotFinite},
    {{0, 0, -kBeyond}, kBeyond, RayFault::kOriginNotFinite},
    {{0, 0, 1}, kNotANumber, RayFault::kBoundNan},
    {{0, 0x1p250, 1}, kBeyond, RayFault::kNone},
    {{0, 0x1.001p250, 1}, kBeyond, RayFault::kOriginTooFar}};

using RayWatchLive = tests::LiveClient;

TEST_F(RayWatchLive, TheServerJudgesPointsTheSame) {
  ASSERT_TRUE(upload_scene(client_, tests::kScene, tests::row_of_sheets(1), {}));
  std::vector<double> positions, most;
  for (const WatchedPoint& point : kWatchedPoints) {
    positions.insert(positions.end(), point.position.begin(), point.position.end());
    most.push_back(point.max);
  }
  std::vector<std::uint8_t> hit(kWatchedPoints.size());
  const auto report =
      client_.nearest(tests::kScene, PointColumns<const double>{positions, most}, {.hit = hit});
  ASSERT_TRUE(report) << report.error().message;
  for (std::size_t i = 0; i < kWatchedPoints.size(); ++i) {
    const RayFault fault = kWatchedPoints[i].fault;
    EXPECT_EQ(fault_of_point(kWatchedPoints[i].position.data(), kWatchedPoints[i].max), fault) << i;
    EXPECT_EQ(hit[i] == 2, fault != RayFault::kNone) << i;
  }
  EXPECT_EQ(info_of(RayFault::kOriginTooFar, files::RowKind::kPoints).key, "position_too_far");
}

TEST_F(RayWatchLive, TheServerJudgesTheSame) {
  const auto scene = tests::row_of_sheets(1);
  ASSERT_TRUE(upload_scene(client_, tests::kScene, scene, {}));
  std::vector<double> origins, directions, tmin, tmax;
  for (const WatchedCase& c : kWatchedCases) {
    origins.insert(origins.end(), c.origin.begin(), c.origin.end());
    directions.insert(directions.end(), c.direction.begin(), c.direction.end());
    tmin.push_back(c.tmin);
    tmax.push_back(c.tmax);
  }
  std::vector<std::uint8_t> hit(kWatchedCases.size());
  HitColumns hits;
  hits.hit = hit;
  const auto report =
      client_.cast(tests::kScene, RayColumns<const double>{origins, directions, tmin, tmax}, hits);
  ASSERT_TRUE(report) << report.error().message;
  for (std::size_t i = 0; i < kWatchedCases.size(); ++i)
    EXPECT_EQ(hit[i] == 2, kWatchedCases[i].fault != RayFault::kNone) << i;
}

}  // namespace
}  // namespace sightline::client::cli::verbs
