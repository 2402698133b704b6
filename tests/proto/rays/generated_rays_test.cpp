// Generated rays against their formulas, whole and in ranges.
#include "proto/rays/generated_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace sightline::proto::rays {
namespace {

using Rays = std::vector<std::pair<Vector, Vector>>;

Rays rays_of(const RayGenerator& generator) {
  GeneratedRays source;
  source.begin(generator);
  Rays rays(source.size());
  source.make(0, rays.size(), [&](std::size_t i, const Vector& origin, const Vector& direction) {
    rays[i] = {origin, direction};
  });
  return rays;
}

void expect_near(const Vector& found, const Vector& expected) {
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[k], expected[k], 1e-14);
}

RayGenerator small_picture() {
  Pinhole pinhole{.eye = {1, 2, 3}, .corner = {-2, 1, -1}, .across = {4, 0, 0}, .down = {0, -2, 0}};
  pinhole.width = 37;
  pinhole.height = 19;
  pinhole.samples = {{0.25, 0.5}, {0.75, 1}, {0, 0}};
  pinhole.tiled = true;
  return {.rays = pinhole};
}

RayGenerator small_scan() {
  SphericalScan scan{.origin = {5, 6, 7}};
  scan.azimuth = {0, 2 * std::numbers::pi};
  scan.elevation = {-0.5, 1};
  scan.columns = 100;
  scan.rows = 9;
  return {.rays = scan};
}

RayGenerator pairs(bool listed) {
  VisibilityPairs pairs{.from = {{0, 0, 0}, {1, 0, 0}, {2, 3, 0}}, .to = {{0, 0, 1}, {0, 1, 1}}};
  if (listed) pairs.pairs = {{2, 1}, {0, 0}, {2, 1}, {1, 0}};
  return {.rays = pairs};
}

TEST(GeneratedRays, APinholeLooksThroughItsSamples) {
  Pinhole one{.corner = {-2, 1, -1}, .across = {4, 0, 0}, .down = {0, -2, 0}};
  one.width = 4;
  one.height = 2;
  const Rays rays = rays_of({.rays = one});
  ASSERT_EQ(rays.size(), 8u);
  // The second pixel of the second row: x = 1.5 / 4, y = 1.5 / 2.
  const Vector way{-0.5, -0.5, -1};
  const double length = std::sqrt(1.5);
  expect_near(rays[5].second, {way[0] / length, way[1] / length, way[2] / length});
  EXPECT_EQ(rays[5].first, Vector{});
}

TEST(GeneratedRays, AScanTurnsLeftAndUp) {
  SphericalScan quarter;
  quarter.azimuth = {0, 2 * std::numbers::pi};
  quarter.elevation = {0, std::numbers::pi / 2};
  quarter.columns = 4;
  quarter.rows = 1;
  const Rays rays = rays_of({.rays = quarter});
  const double half = std::sqrt(0.5);
  expect_near(rays[0].second, {half * half, half * half, half});
  expect_near(rays[1].second, {-half * half, half * half, half});
  expect_near(rays[3].second, {half * half, -half * half, half});
}

TEST(GeneratedRays, PairsGoFromPointToPoint) {
  const Rays all = rays_of(pairs(false));
  ASSERT_EQ(all.size(), 6u);
  EXPECT_EQ(all[3], (std::pair<Vector, Vector>{{1, 0, 0}, {-1, 1, 1}}));
  EXPECT_EQ(all[4], (std::pair<Vector, Vector>{{2, 3, 0}, {-2, -3, 1}}));
  const Rays listed = rays_of(pairs(true));
  ASSERT_EQ(listed.size(), 4u);
  EXPECT_EQ(listed[0], (std::pair<Vector, Vector>{{2, 3, 0}, {-2, -2, 1}}));
  EXPECT_EQ(listed[3], (std::pair<Vector, Vector>{{1, 0, 0}, {-1, 0, 1}}));
}

TEST(GeneratedRays, RangesAndPartsHaveTheBitsOfTheWhole) {
  for (const RayGenerator& generator : {small_picture(), small_scan(), pairs(false), pairs(true)}) {
    const Rays whole = rays_of(generator);
    RayGenerator some = generator;
    for (std::size_t first = 0; first < whole.size(); first += 1 + whole.size() / 13) {
      some.first = first;
      some.count = std::min<std::size_t>(whole.size() - first, 250);
      GeneratedRays source;
      source.begin(some);
      const std::size_t half = source.size() / 2;
      for (const auto& [begin, count] :
           {std::pair{std::size_t{0}, half}, std::pair{half, source.size() - half}}) {
        source.make(begin, count, [&, at = begin](std::size_t i, const Vector& o, const Vector& d) {
          EXPECT_EQ(std::pair(o, d), whole[first + at + i]);
        });
      }
    }
  }
}

TEST(GeneratedRays, BeginReplacesTheGenerator) {
  GeneratedRays rays;
  rays.begin(small_scan());
  RayGenerator next = pairs(true);
  next.tmin = 0.25;
  next.mask = 6;
  rays.begin(next);
  EXPECT_EQ(rays.size(), 4u);
  EXPECT_EQ(rays.tmin(), 0.25);
  EXPECT_EQ(rays.tmax(), 1);
  EXPECT_EQ(rays.mask(), 6u);
}

}  // namespace
}  // namespace sightline::proto::rays
