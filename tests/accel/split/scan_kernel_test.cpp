// The scan kernels against plain counting, on every SIMD target of this machine.
#include "accel/split/scan_kernel.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::split {
namespace {

std::vector<kdtree::Reference> boxes(std::size_t n, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<kdtree::Reference> refs(n);
  for (std::size_t i = 0; i < n; ++i) {
    geometry::Aabb box;
    // Multiples of one eighth: bounds meet sample planes exactly.
    const auto p = [&] { return static_cast<float>(random.below(65)) / 8; };
    box.grow(geometry::Vec3f{p(), p(), p()});
    box.grow(geometry::Vec3f{p(), p(), p()});
    box = widen_flat(box);
    refs[i] = {box.lo, static_cast<std::uint32_t>(i), box.hi,
               static_cast<std::uint32_t>(1 + random.below(5))};
  }
  return refs;
}

template <std::size_t kPlanes>
std::array<float, kPlanes> planes(std::uint64_t seed) {
  tests::Random random(seed);
  std::array<float, kPlanes> axis;
  for (float& x : axis) x = static_cast<float>(random.below(65)) / 8;
  return axis;
}

template <std::size_t kPlanes>
kdtree::PlaneCounts<kPlanes> counted(const std::vector<kdtree::Reference>& refs, std::size_t axis,
                                     const std::array<float, kPlanes>& planes) {
  kdtree::PlaneCounts<kPlanes> counts;
  for (std::size_t i = 0; i < kPlanes; ++i) {
    for (const kdtree::Reference& r : refs) {
      counts.left[i] += r.lo[axis] < planes[i] ? r.weight : 0;
      counts.right[i] += r.hi[axis] > planes[i] ? r.weight : 0;
    }
  }
  return counts;
}

PlaneNeighbours neighbours(const std::vector<kdtree::Reference>& refs, std::size_t axis,
                           const WideAxis& planes) {
  PlaneNeighbours near;
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    const auto below = [&](float x) { near.below[i] = std::max(near.below[i], x); };
    const auto above = [&](float x) { near.above[i] = std::min(near.above[i], x); };
    for (const kdtree::Reference& r : refs) {
      r.lo[axis] < planes[i] ? below(r.lo[axis]) : above(r.lo[axis]);
      r.hi[axis] > planes[i] ? above(r.hi[axis]) : below(r.hi[axis]);
    }
  }
  return near;
}

using ScanKernel = tests::OnSimdTarget;

TEST_P(ScanKernel, CountsWeights) {
  for (const std::size_t n : {0u, 1u, 2u, 7u, 36u, 1000u}) {
    const std::vector<kdtree::Reference> refs = boxes(n, n);
    const std::array<UniformAxis, 3> at{planes<kdtree::kUniformPlanes>(1),
                                        planes<kdtree::kUniformPlanes>(2),
                                        planes<kdtree::kUniformPlanes>(3)};
    std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3> counts;
    scan_three_axes(refs, at, counts);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(counts[a], counted(refs, a, at[a])) << n << " on " << a;
      kdtree::PlaneCounts<kdtree::kUniformPlanes> one;
      scan_one_axis(refs, static_cast<int>(a), at[a], one);
      EXPECT_EQ(one, counts[a]) << n << " on " << a;
    }
  }
}

TEST_P(ScanKernel, FindsTheBoundsNextToPlanes) {
  for (const std::size_t n : {0u, 1u, 2u, 7u, 36u, 1000u}) {
    const std::vector<kdtree::Reference> refs = boxes(n, n);
    for (std::size_t a = 0; a < 3; ++a) {
      const WideAxis at = planes<kScanWidth>(a);
      kdtree::PlaneCounts<kScanWidth> counts;
      PlaneNeighbours near;
      scan_wide_axis(refs, static_cast<int>(a), at, counts, near);
      EXPECT_EQ(counts, counted(refs, a, at)) << n << " on " << a;
      EXPECT_EQ(near, neighbours(refs, a, at)) << n << " on " << a;
    }
  }
}

/// Piece after piece, into the same counts.
TEST_P(ScanKernel, AccumulatesPieces) {
  const std::vector<kdtree::Reference> refs = boxes(100, 3);
  const std::span<const kdtree::Reference> all(refs);
  const WideAxis at = planes<kScanWidth>(5);
  kdtree::PlaneCounts<kScanWidth> whole, pieces;
  PlaneNeighbours whole_near, pieces_near;
  scan_wide_axis(all, 1, at, whole, whole_near);
  for (const auto& [begin, size] : {std::pair{0u, 1u}, {1u, 0u}, {1u, 60u}, {61u, 39u}})
    scan_wide_axis(all.subspan(begin, size), 1, at, pieces, pieces_near);
  EXPECT_EQ(whole, pieces);
  EXPECT_EQ(whole_near, pieces_near);
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, ScanKernel, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::split
