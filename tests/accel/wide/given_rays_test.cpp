// Rays are read from columns of any layout, bit for bit.
#include "accel/wide/given_rays.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::RayColumns;
using geometry::RealColumn;
using tests::Random;

class GivenRaysOn : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, GivenRaysOn, tests::every_simd_target(), tests::simd_target_name);

std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }

constexpr std::size_t kRays = 3 * kLanes;

float number(Random& random) {
  switch (random.below(8)) {
    case 0:
      return std::numeric_limits<float>::infinity();
    case 1:
      return std::nanf("");
    case 2:
      return -0.0f;
    default:
      return static_cast<float>(random.uniform(-10, 10));
  }
}

/// Numbers in memory of their exact length, which begins as many bytes behind an aligned place.
class Numbers {
 public:
  Numbers(Random& random, std::size_t count, bool float64, std::size_t misaligned)
      : bytes_(misaligned + count * (float64 ? sizeof(double) : sizeof(float))),
        misaligned_(misaligned) {
    for (std::size_t i = 0; i < count; ++i) {
      const float narrow = number(random);
      const double wide = static_cast<double>(narrow) * random.uniform(1, 2);
      if (float64) {
        put(i, wide);
      } else {
        put(i, narrow);
      }
    }
  }
  const void* data() const { return bytes_.data() + misaligned_; }

 private:
  template <class T>
  void put(std::size_t i, T value) {
    std::memcpy(bytes_.data() + misaligned_ + i * sizeof(T), &value, sizeof(T));
  }
  std::vector<std::byte> bytes_;
  std::size_t misaligned_;
};

enum class Layout { kOneForAll, kSideBySide, kRowsOfThree, kStrided };
constexpr Layout kLayouts[] = {Layout::kOneForAll, Layout::kSideBySide, Layout::kRowsOfThree,
                               Layout::kStrided};

std::size_t stride_of(Layout layout) {
  constexpr std::size_t kStrides[] = {0, 1, 3, 5};
  return kStrides[static_cast<std::size_t>(layout)];
}

/// Eight columns of random numbers; the first three and the next three may share their rows.
struct RandomColumns {
  RandomColumns(Random& random, Layout layout, bool float64, std::size_t misaligned) {
    const std::size_t stride = stride_of(layout);
    const std::size_t count = stride == 0 ? 1 : kRays * stride;
    const auto make = [&] {
      return numbers.emplace_back(random, count, float64, misaligned).data();
    };
    numbers.reserve(8);
    rays.size = kRays;
    for (std::array<RealColumn, 3>* vector : {&rays.origin, &rays.direction}) {
      if (layout == Layout::kRowsOfThree) {
        *vector = geometry::columns_of_rows(make(), float64);
        continue;
      }
      for (RealColumn& column : *vector) column = {make(), stride, float64};
    }
    rays.tmin = {make(), stride, float64};
    rays.tmax = {make(), stride, float64};
  }
  std::vector<Numbers> numbers;
  RayColumns rays;
};

void expect_read(const RayColumns& rays, std::size_t first, std::size_t count) {
  const auto given = std::make_unique<GivenRays>();
  read(rays, first, count, *given);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const geometry::Ray ray = rays[first + std::min(lane, count - 1)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(bits_of(given->origin[axis][lane]), bits_of(ray.origin[axis]));
      ASSERT_EQ(bits_of(given->direction[axis][lane]), bits_of(ray.direction[axis]));
    }
    ASSERT_EQ(bits_of(given->tmin[lane]), bits_of(ray.tmin));
    ASSERT_EQ(bits_of(given->tmax[lane]), bits_of(ray.tmax));
  }
}

TEST_P(GivenRaysOn, EveryLayoutIsRead) {
  Random random(1);
  for (const Layout layout : kLayouts) {
    for (const bool float64 : {false, true}) {
      for (const std::size_t misaligned : {0u, 1u, 4u}) {
        const RandomColumns columns(random, layout, float64, misaligned);
        for (std::size_t count = 1; count <= kLanes; ++count) {
          for (const std::size_t first : {std::size_t{0}, kLanes, kRays - count})
            ASSERT_NO_FATAL_FAILURE(expect_read(columns.rays, first, count));
        }
      }
    }
  }
}

TEST_P(GivenRaysOn, LayoutsAndTypesMix) {
  Random random(2);
  for (int turn = 0; turn < 200; ++turn) {
    const auto any = [&] {
      return RandomColumns(random, kLayouts[random.below(4)], random.below(2) == 0,
                           random.below(2));
    };
    const RandomColumns a = any(), b = any(), c = any(), d = any();
    RayColumns mixed = a.rays;
    mixed.origin[1] = b.rays.origin[random.below(3)];
    mixed.direction = c.rays.direction;
    mixed.tmin = d.rays.tmin;
    ASSERT_NO_FATAL_FAILURE(expect_read(mixed, kLanes, kLanes));
    mixed.direction[2] = c.rays.direction[0];
    ASSERT_NO_FATAL_FAILURE(expect_read(mixed, kLanes, kLanes));
  }
}

TEST(RayColumnsTest, AreTheNumbersOfAnArray) {
  const std::vector<geometry::Ray> rays{{{1, 2, 3}, {4, 5, 6}, 7, 8, 9},
                                        {{11, 12, 13}, {14, 15, 16}, 17, 18, 19}};
  const RayColumns columns = geometry::columns_of(rays);
  ASSERT_EQ(columns.size, rays.size());
  const geometry::Ray second = columns[1];
  EXPECT_EQ(second.origin, rays[1].origin);
  EXPECT_EQ(second.direction, rays[1].direction);
  EXPECT_EQ(second.tmin, 17);
  EXPECT_EQ(second.tmax, 18);
  EXPECT_EQ(second.mask, 19u);
}

TEST(RayColumnsTest, LimitsAndMasksMayBeLeftOut) {
  const std::array<float, 6> numbers{1, 2, 3, 4, 5, 6};
  RayColumns columns;
  columns.size = 2;
  columns.origin = columns.direction = geometry::columns_of_rows(numbers.data(), false);
  const geometry::Ray second = columns[1], plain;
  EXPECT_EQ(second.origin, (geometry::Vec3d{4, 5, 6}));
  EXPECT_EQ(second.tmin, plain.tmin);
  EXPECT_EQ(second.tmax, plain.tmax);
  EXPECT_EQ(second.mask, plain.mask);
}

}  // namespace
}  // namespace sightline::accel::wide
