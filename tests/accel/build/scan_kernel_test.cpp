// The scan kernels against plain counting, on every SIMD target of this machine.
#include "accel/build/scan_kernel.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <vector>

#include "tests/support/random.h"

namespace sightline::accel {
namespace {

std::vector<BoxRef> boxes(std::size_t n, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<BoxRef> refs(n);
  for (std::size_t i = 0; i < n; ++i) {
    Aabb box;
    // Eighths: bounds meet sample planes exactly.
    const auto p = [&] { return static_cast<float>(random.below(65)) / 8; };
    box.grow(Vec3f{p(), p(), p()});
    box.grow(Vec3f{p(), p(), p()});
    box = widen_flat(box);
    refs[i] = {box.lo, static_cast<std::uint32_t>(i), box.hi,
               static_cast<std::uint32_t>(1 + random.below(5))};
  }
  return refs;
}

ScanAxis planes(std::uint64_t seed) {
  tests::Random random(seed);
  ScanAxis axis;
  for (float& x : axis.position) x = static_cast<float>(random.below(65)) / 8;
  return axis;
}

void expect_counts(const std::vector<BoxRef>& refs, std::size_t axis, const ScanAxis& counted,
                   std::size_t used) {
  for (std::size_t i = 0; i < used; ++i) {
    std::uint32_t left = 0, right = 0;
    for (const BoxRef& r : refs) {
      left += r.lo[axis] < counted.position[i] ? r.weight : 0;
      right += r.hi[axis] > counted.position[i] ? r.weight : 0;
    }
    ASSERT_EQ(counted.left[i], left) << "axis " << axis << " plane " << i;
    ASSERT_EQ(counted.right[i], right) << "axis " << axis << " plane " << i;
  }
}

class ScanKernel : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(ScanKernel, CountsWeights) {
  for (const std::size_t n : {0u, 1u, 2u, 7u, 36u, 1000u}) {
    const std::vector<BoxRef> refs = boxes(n, n);
    std::array<ScanAxis, 3> axes{planes(1), planes(2), planes(3)};
    scan_three_axes(refs, axes);
    for (std::size_t a = 0; a < 3; ++a) expect_counts(refs, a, axes[a], kScanWidth / 2);
    for (int a = 0; a < 3; ++a) {
      ScanAxis one = planes(4);
      scan_one_axis(refs, a, one);
      expect_counts(refs, static_cast<std::size_t>(a), one, kScanWidth / 2);
    }
  }
}

std::vector<std::int64_t> targets_here() {
  std::vector<std::int64_t> all;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1)
    all.push_back(left & -left);
  return all;
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, ScanKernel, ::testing::ValuesIn(targets_here()),
                         [](const auto& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace sightline::accel
