// The fused pass against separate sift and scan passes, on every SIMD target of this machine.
#include "accel/split/child_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/accel/boxes.h"
#include "tests/accel/simd_targets.h"

namespace sightline::accel::split {
namespace {

using FirstScanning = tests::OnSimdTarget;

bool same(const kdtree::Reference& a, const kdtree::Reference& b) {
  return a.lo == b.lo && a.hi == b.hi && a.id == b.id && a.weight == b.weight;
}

bool same(std::span<const kdtree::Reference> a, std::span<const kdtree::Reference> b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(),
      [](const kdtree::Reference& x, const kdtree::Reference& y) { return same(x, y); });
}

struct Divided {
  std::vector<kdtree::Reference> left, right;
  ChildScans scans;
};

ChildScans unscanned(const geometry::Aabb& cell, const kdtree::Plane& plane,
                     std::uint32_t samples) {
  const geometry::HalvedCell halves = halve(cell, plane.axis, plane.position);
  return {child_planes(halves.left, samples), child_planes(halves.right, samples), {}, {}};
}

/// By the definition.
Divided separate_passes(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                        const kdtree::Plane& plane, std::uint32_t samples) {
  Divided d{.left = std::vector<kdtree::Reference>(refs.size()),
            .right = std::vector<kdtree::Reference>(refs.size()),
            .scans = unscanned(cell, plane, samples)};
  const kdtree::PartitionCounts n =
      kdtree::sift(refs, {.plane = plane}, d.left.data(), d.right.data());
  d.left.resize(n.left);
  d.right.resize(n.right);
  d.scans.left.references = n.left;
  d.scans.right.references = n.right;
  const auto count = [](const std::vector<kdtree::Reference>& list, const ChildPlanes& planes,
                        kdtree::ChildScan& scan) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < kdtree::kUniformPlanes; ++i) {
        for (const kdtree::Reference& r : list) {
          scan.axes[a].left[i] += r.lo[a] < planes.at[a][i] ? r.weight : 0;
          scan.axes[a].right[i] += r.hi[a] > planes.at[a][i] ? r.weight : 0;
        }
      }
    }
  };
  count(d.left, d.scans.left_planes, d.scans.left);
  count(d.right, d.scans.right_planes, d.scans.right);
  return d;
}

/// In place, as growth does, then piece by piece into one pair of lists.
void expect_same(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                 const kdtree::Plane& plane, std::uint32_t samples = kdtree::kUniformPlanes) {
  const Divided expected = separate_passes(refs, cell, plane, samples);
  const auto expect_lists = [&](std::span<const kdtree::Reference> left,
                                std::span<const kdtree::Reference> right, const ChildScans& scans) {
    EXPECT_TRUE(same(left, expected.left));
    EXPECT_TRUE(same(right, expected.right));
    EXPECT_EQ(scans.left, expected.scans.left);
    EXPECT_EQ(scans.right, expected.scans.right);
  };
  std::vector<kdtree::Reference> left = refs, right(refs.size());
  ChildScans scans = unscanned(cell, plane, samples);
  const kdtree::PartitionCounts n = sift_and_count(left, plane, left.data(), right.data(), scans);
  expect_lists(std::span(left).first(n.left), std::span(right).first(n.right), scans);

  const std::size_t third = refs.size() / 3;
  const std::span<const kdtree::Reference> all(refs);
  kdtree::PartitionCounts sum;
  ChildScans summed = unscanned(cell, plane, samples);
  for (const auto piece : {all.first(third), all.subspan(third, third), all.subspan(2 * third)}) {
    ChildScans own = unscanned(cell, plane, samples);
    const kdtree::PartitionCounts m =
        sift_and_count(piece, plane, left.data() + sum.left, right.data() + sum.right, own);
    sum = {sum.left + m.left, sum.right + m.right};
    summed.left += own.left;
    summed.right += own.right;
  }
  expect_lists(std::span(left).first(sum.left), std::span(right).first(sum.right), summed);
}

TEST_P(FirstScanning, EqualsASeparateSiftAndScan) {
  for (std::size_t n = 0; n <= 70; ++n) {
    SCOPED_TRACE(n);
    const auto refs = tests::random_boxes(n, 0.3, n);
    const int axis = static_cast<int>(n % 3);
    expect_same(refs, {{0, 0, 0}, {1, 1, 1}}, {axis, 0.4f});
    expect_same(refs, {{0.2f, 0.3f, 0.1f}, {0.8f, 0.7f, 0.9f}}, {axis, 0.5f});  // Straddlers
  }
}

TEST_P(FirstScanning, CountsFlatBoxesWeightsAndTies) {
  for (std::size_t n = 0; n <= 70; ++n) {
    SCOPED_TRACE(n);
    const auto refs = tests::lattice_boxes(n, 9, n);
    for (const float x : {1.0f, 2.0f, 2.5f})
      expect_same(refs, {{0, 0, 0}, {5, 5, 5}}, {static_cast<int>(n % 3), x}, 6);
  }
}

TEST_P(FirstScanning, LeavesASideEmpty) {
  const auto refs = tests::random_boxes(50, 0.1, 1);
  const geometry::Aabb cell{{-1, -1, -1}, {3, 3, 3}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const float x : {-0.5f, 2.5f}) expect_same(refs, cell, {axis, x}, 2);
  }
}

TEST_P(FirstScanning, CountsLongLists) {
  const auto refs = tests::random_boxes(5000, 0.01, 2);
  expect_same(refs, kdtree::bounds_of(refs), {1, 0.3f});
}

TEST(ChildScan, CoversAListOfItsSizeThatIsNotEmpty) {
  kdtree::ChildScan scan;
  EXPECT_FALSE(scan.covers(0));
  EXPECT_FALSE(scan.covers(3));
  scan.references = 3;
  EXPECT_TRUE(scan.covers(3));
  EXPECT_FALSE(scan.covers(4));
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, FirstScanning, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::split
