// What is refused, and how many rays there are.
#include "proto/rays/generator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace sightline::proto::rays {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

RayGenerator pinhole() {
  Pinhole pinhole;
  pinhole.corner = {-1, 1, -1};
  pinhole.across = {2, 0, 0};
  pinhole.down = {0, -2, 0};
  pinhole.width = 4;
  pinhole.height = 3;
  return {.rays = pinhole};
}

RayGenerator scan() {
  SphericalScan scan;
  scan.azimuth = {-3, 3};
  scan.elevation = {1, -1};
  scan.columns = 5;
  scan.rows = 2;
  return {.rays = scan};
}

RayGenerator pairs() {
  VisibilityPairs pairs{.from = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, .to = {{0, 0, 1}, {0, 1, 1}}};
  return {.rays = pairs};
}

/// The message and the reason of the problem after an edit; empty if there is none.
template <class Kind>
std::string problem_of(RayGenerator generator, const std::function<void(Kind&)>& edit) {
  edit(std::get<Kind>(generator.rays));
  const auto problem = check(generator);
  return problem ? std::string(problem->reason) + ": " + problem->message : "";
}

TEST(RayGenerator, CountsItsRays) {
  EXPECT_EQ(count_of(pinhole()), 12u);
  EXPECT_EQ(count_of(scan()), 10u);
  EXPECT_EQ(count_of(pairs()), 6u);
  RayGenerator some = pinhole();
  std::get<Pinhole>(some.rays).samples = {{0, 0}, {0.5, 1}};
  EXPECT_EQ(count_of(some), 24u);
  some.first = 20;
  EXPECT_EQ(count_of(some), 4u);
  some.count = 3;
  EXPECT_EQ(count_of(some), 3u);
  EXPECT_EQ(total_of(some), 24u);
  EXPECT_EQ(count_of(RayGenerator{.rays = VisibilityPairs{}}), 0u);
}

TEST(RayGenerator, PairsEndAtTheSecondPoint) {
  EXPECT_EQ(tmax_of(pairs()), 1);
  EXPECT_EQ(tmax_of(scan()), kInfinity);
  RayGenerator limited = pairs();
  limited.tmax = 0.5;
  EXPECT_EQ(tmax_of(limited), 0.5);
}

TEST(RayGenerator, AcceptsWhatIsWithinTheLimits) {
  EXPECT_FALSE(check(pinhole()));
  EXPECT_FALSE(check(scan()));
  EXPECT_FALSE(check(pairs()));
  EXPECT_FALSE(check(RayGenerator{.rays = VisibilityPairs{}}));
}

TEST(RayGenerator, NamesTheFieldTheValueAndTheLimit) {
  EXPECT_EQ(problem_of<Pinhole>(pinhole(), [](Pinhole& p) { p.down[1] = kInfinity; }),
            "NOT_FINITE: down holds inf, which is not finite");
  EXPECT_EQ(problem_of<Pinhole>(pinhole(), [](Pinhole& p) { p.width = 0; }),
            "BAD_SIZE: width is 0, not from 1 to 1048576");
  EXPECT_EQ(problem_of<Pinhole>(pinhole(), [](Pinhole& p) { p.height = kMaxSide + 1; }),
            "BAD_SIZE: height is 1048577, not from 1 to 1048576");
  EXPECT_EQ(problem_of<Pinhole>(pinhole(),
                                [](Pinhole& p) {
                                  p.samples = {{0, 1.5}};
                                }),
            "BAD_SAMPLE: a sample is at 1.5, not from 0 to 1");
  EXPECT_EQ(problem_of<Pinhole>(pinhole(), [](Pinhole& p) { p.samples.resize(65); }),
            "TOO_MANY_SAMPLES: a pixel has 65 samples, the limit is 64");
  EXPECT_EQ(problem_of<SphericalScan>(scan(), [](SphericalScan& s) { s.azimuth[1] = 65; }),
            "BAD_ANGLE: azimuth holds 65, not from -64 to 64 (radians)");
  EXPECT_NE(problem_of<SphericalScan>(scan(), [](SphericalScan& s) { s.elevation[0] = kNan; }), "");
  EXPECT_EQ(problem_of<SphericalScan>(scan(), [](SphericalScan& s) { s.rows = 0; }),
            "BAD_SIZE: rows is 0, not from 1 to 1048576");
  EXPECT_EQ(problem_of<VisibilityPairs>(pairs(),
                                        [](VisibilityPairs& p) {
                                          p.pairs = {{0, 1}, {2, 2}};
                                        }),
            "NO_SUCH_POINT: pair 1 names point 2 of to, which has 2");
  EXPECT_EQ(problem_of<VisibilityPairs>(pairs(),
                                        [](VisibilityPairs& p) { p.from.resize(kMaxPoints + 1); }),
            "TOO_MANY_POINTS: from holds 16385, the limit is 16384");
}

TEST(RayGenerator, ChecksTheRangeAndTheInterval) {
  RayGenerator generator = scan();
  generator.first = 8;
  generator.count = 3;
  EXPECT_EQ(check(generator)->message,
            "rays 8 and the next 3 are asked for, but the generator has 10");
  generator.first = std::numeric_limits<std::uint64_t>::max();
  generator.count = 2;
  EXPECT_TRUE(check(generator)) << "their sum overflows";
  generator = scan();
  generator.tmin = kNan;
  EXPECT_EQ(check(generator)->message, "tmin holds nan, which is not finite");
  generator = scan();
  generator.tmax = kNan;
  EXPECT_EQ(check(generator)->message, "tmax is nan");
  generator.tmax = kInfinity;
  EXPECT_FALSE(check(generator));
}

}  // namespace
}  // namespace sightline::proto::rays
