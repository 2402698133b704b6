// Packets are transformed into frames as single rays are, bit for bit.
#include "accel/wide/transform.h"

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "accel/geometry/local_ray.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::kInfinity;
using geometry::LocalRay;
using geometry::Ray;
using geometry::Vec3d;
using tests::Random;

class Transforms : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Transforms, tests::every_simd_target(), tests::simd_target_name);

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// Any double, more often one at the ends of a range that rays may have.
double hard_number(Random& random) {
  static const std::vector<double> ends{0.0,
                                        -0.0,
                                        std::numeric_limits<double>::denorm_min(),
                                        std::numeric_limits<double>::min(),
                                        std::numeric_limits<double>::max(),
                                        kInfinity,
                                        std::nan(""),
                                        geometry::kSmallestRay,
                                        std::nextafter(geometry::kSmallestRay, 0.0),
                                        geometry::kLargestRay,
                                        std::nextafter(geometry::kLargestRay, kInfinity),
                                        0x1p-1000,
                                        std::nextafter(0x1p-1000, 0.0),
                                        0x1p+1001,
                                        std::nextafter(0x1p+1001, 0.0)};
  const double sign = random.below(2) == 0 ? 1 : -1;
  switch (random.below(8)) {
    case 0:
      return sign * ends[random.below(ends.size())];
    case 1:
      return std::bit_cast<double>(random.next());
    case 2:
      return sign * std::exp2(random.uniform(-1074, 1023));
    case 3:
      return static_cast<double>(random.below(5)) - 2;
    default:
      return random.uniform(-10, 10);
  }
}

Vec3d hard_vector(Random& random) {
  return {hard_number(random), hard_number(random), hard_number(random)};
}

/// Every other packet has rays without surprises.
std::vector<Ray> hard_rays(Random& random, std::size_t count) {
  const bool plain = random.below(2) == 0;
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    if (plain) {
      rays.push_back({random.direction() * 5.0, random.direction()});
    } else {
      rays.push_back(
          {hard_vector(random), hard_vector(random), hard_number(random), hard_number(random)});
    }
  }
  return rays;
}

/// Shears, mirrors, translations and scales, from tiny to huge; some are no transforms at all.
std::vector<Matrix> matrices(Random& random) {
  std::vector<Matrix> all{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                          {-1, 0, 0, 3, 0, 1, 0, -2, 0, 0, 1, 0.1},
                          {1, 5, -3, 0, 0, 1, 7, 0, 0, 0, 1, 0},
                          {0, 0, 1, 1e9, 1, 0, 0, -1e9, 0, 1, 0, 1e-9}};
  for (const int exponent : {-1040, -300, -60, 60, 300, 1020}) {
    Matrix scaled{};
    for (std::size_t row = 0; row < 3; ++row)
      scaled[5 * row] = std::ldexp(random.uniform(-2, 2), exponent);
    all.push_back(scaled);
  }
  for (int i = 0; i < 6; ++i) {
    Matrix any;
    for (double& x : any) x = i < 3 ? random.uniform(-3, 3) : hard_number(random);
    all.push_back(any);
  }
  return all;
}

Vec3d transformed(const Matrix& m, const Vec3d& v, bool is_point) {
  Vec3d out;
  for (std::size_t row = 0; row < 3; ++row) {
    out[row] = m[4 * row] * v.x + m[4 * row + 1] * v.y + m[4 * row + 2] * v.z;
    if (is_point) out[row] += m[4 * row + 3];
  }
  return out;
}

struct Counts {
  std::size_t taken = 0, refused = 0;
};

/// `good`: the lanes for which setting `rays` succeeded, of which one is looked at.
void expect_equal(const Rays& rays, std::uint32_t good, std::size_t lane, const Vec3d& origin,
                  const Vec3d& direction, Counts& counts) {
  LocalRay expected;
  const bool succeeds = set_local_ray(origin, direction, expected);
  ++(succeeds ? counts.taken : counts.refused);
  ASSERT_EQ((good >> lane & 1) != 0, succeeds);
  if (!succeeds) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ASSERT_EQ(bits(rays.origin[axis][lane]), bits(expected.origin[axis]));
    ASSERT_EQ(bits(rays.direction[axis][lane]), bits(expected.direction[axis]));
  }
  ASSERT_EQ(bits(rays.unit[lane]), bits(expected.unit));
}

std::uint32_t first_lanes(std::size_t count) { return (2u << (count - 1)) - 1; }

TEST_P(Transforms, ReadsRaysInColumnsAndRepeatsTheLast) {
  Random random(1);
  const auto given = std::make_unique<GivenRays>();
  for (std::size_t turn = 0; turn < 200; ++turn) {
    const std::vector<Ray> rays = hard_rays(random, 1 + turn % kLanes);
    read(rays, *given);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Ray& ray = rays[std::min(lane, rays.size() - 1)];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(bits(given->origin[axis][lane]), bits(ray.origin[axis]));
        ASSERT_EQ(bits(given->direction[axis][lane]), bits(ray.direction[axis]));
      }
      ASSERT_EQ(bits(given->tmin[lane]), bits(ray.tmin));
      ASSERT_EQ(bits(given->tmax[lane]), bits(ray.tmax));
    }
  }
}

TEST_P(Transforms, RaysInAFrameEqualSingleOnes) {
  Random random(2);
  const auto given = std::make_unique<GivenRays>();
  const auto transformed_rays = std::make_unique<Rays>();
  Counts counts;
  for (std::size_t turn = 0; turn < 400; ++turn) {
    const std::vector<Ray> rays = hard_rays(random, 1 + turn % kLanes);
    const std::uint32_t lanes = first_lanes(rays.size());
    read(rays, *given);
    for (const Matrix& matrix : matrices(random)) {
      const std::uint32_t good = transform(*given, matrix, lanes, *transformed_rays);
      ASSERT_EQ(good & ~lanes, 0u);
      for (std::size_t lane = 0; lane < rays.size(); ++lane) {
        ASSERT_NO_FATAL_FAILURE(expect_equal(
            *transformed_rays, good, lane, transformed(matrix, rays[lane].origin, true),
            transformed(matrix, rays[lane].direction, false), counts));
      }
    }
  }
  EXPECT_GT(counts.taken, 1000u);
  EXPECT_GT(counts.refused, 1000u);
}

TEST_P(Transforms, RaysAroundACenterEqualSingleOnes) {
  Random random(3);
  const auto given = std::make_unique<GivenRays>();
  const auto centered = std::make_unique<Rays>();
  Counts counts, limits;
  for (std::size_t turn = 0; turn < 2000; ++turn) {
    const std::vector<Ray> rays = hard_rays(random, 1 + turn % kLanes);
    const std::uint32_t lanes = first_lanes(rays.size());
    read(rays, *given);
    const Vec3d at = turn % 3 == 0   ? Vec3d{}
                     : turn % 3 == 1 ? random.direction() * 1e6
                                     : Vec3d{0x1p+200, -0x1p-200, 1};
    const std::uint32_t good = center(*given, at, lanes, *centered),
                        asked = valid(*given, at, lanes);
    ASSERT_EQ((good | asked) & ~lanes, 0u);
    for (std::size_t lane = 0; lane < rays.size(); ++lane) {
      const Ray& ray = rays[lane];
      ASSERT_NO_FATAL_FAILURE(
          expect_equal(*centered, good, lane, ray.origin - at, ray.direction, counts));
      const bool has_limits = !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
      ++(has_limits ? limits.taken : limits.refused);
      ASSERT_EQ((asked >> lane & 1) != 0, (good >> lane & 1) != 0 && has_limits);
    }
  }
  EXPECT_GT(counts.taken, 1000u);
  EXPECT_GT(counts.refused, 1000u);
  EXPECT_GT(limits.refused, 100u);
}

TEST_P(Transforms, LimitsStayTheSame) {
  Random random(4);
  const auto given = std::make_unique<GivenRays>();
  const auto transformed_rays = std::make_unique<Rays>(), centered = std::make_unique<Rays>();
  const std::vector<Ray> rays = hard_rays(random, kLanes);
  read(rays, *given);
  transform(*given, matrices(random).back(), first_lanes(kLanes), *transformed_rays);
  center(*given, {1, 2, 3}, first_lanes(kLanes), *centered);
  for (const Rays* out : {transformed_rays.get(), centered.get()}) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      EXPECT_EQ(bits(out->tmin[lane]), bits(rays[lane].tmin));
      EXPECT_EQ(bits(out->tmax[lane]), bits(rays[lane].tmax));
    }
  }
}

TEST_P(Transforms, OnlyTheLanesThatAreAskedFor) {
  const std::vector<Ray> rays(kLanes, Ray{{1, 2, 3}, {4, 5, 6}});
  const auto given = std::make_unique<GivenRays>();
  const auto out = std::make_unique<Rays>();
  read(rays, *given);
  const Matrix same{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  for (const std::uint32_t lanes : {0u, 1u, 0x8000u, 0x5a5au}) {
    EXPECT_EQ(valid(*given, {}, lanes), lanes);
    EXPECT_EQ(transform(*given, same, lanes, *out), lanes);
    EXPECT_EQ(center(*given, {}, lanes, *out), lanes);
  }
}

TEST_P(Transforms, EveryKindOfBadComponentIsRefused) {
  const auto given = std::make_unique<GivenRays>();
  const double nan = std::nan("");
  for (std::size_t number = 0; number < 8; ++number) {
    for (const double bad : {nan, kInfinity, -kInfinity}) {
      std::vector<Ray> rays(kLanes, Ray{{1, 2, 3}, {4, 5, 6}});
      Ray& ray = rays[number];
      (number < 3   ? ray.origin[number]
       : number < 6 ? ray.direction[number - 3]
       : number < 7 ? ray.tmin
                    : ray.tmax) = bad;
      read(rays, *given);
      const bool may_be = number >= 6 && !std::isnan(bad);
      EXPECT_EQ(valid(*given, {}, 0xffffu), may_be ? 0xffffu : 0xffffu & ~(1u << number));
    }
  }
}

}  // namespace
}  // namespace sightline::accel::wide
