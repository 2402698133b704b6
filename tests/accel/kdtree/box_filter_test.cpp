// The filter keeps every box that a ray may meet, on every SIMD target, and few others.
#include "accel/kdtree/box_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "accel/geometry/aabb.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::kdtree {
namespace {

using geometry::Aabb;
using geometry::LocalRay;
using geometry::Vec3d;
using geometry::Vec3f;

std::vector<Reference> random_boxes(std::size_t count, double size, const Vec3d& at,
                                    std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<Reference> boxes(count);
  for (Reference& box : boxes) {
    const Vec3d corner = at + Vec3d{random.uniform(), random.uniform(), random.uniform()} * size;
    const Vec3d extent =
        Vec3d{random.uniform(), random.uniform(), random.uniform()} * (size * random.uniform() / 4);
    const Aabb cell = geometry::widen_flat({Vec3f(corner), Vec3f(corner + extent)});
    // Bits that are not numbers, where a vector reads them as floats.
    box = {cell.lo, static_cast<std::uint32_t>(0xffc00000u + random.below(100)), cell.hi,
           0x7f800000u};
  }
  return boxes;
}

/// At corners and centers of boxes; some along axes, some in the planes of faces.
std::vector<LocalRay> rays_at(const std::vector<Reference>& boxes, double distance,
                              std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<LocalRay> rays;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Vec3d lo(boxes[i].lo), hi(boxes[i].hi);
    const Vec3d target = i % 3 == 0 ? lo : i % 3 == 1 ? hi : lo + (hi - lo) * random.uniform();
    Vec3d direction = random.direction();
    if (i % 4 == 1) direction[i % 3] = 0;
    if (i % 4 == 2)
      direction = {i % 3 == 0 ? 1.0 : 0.0, i % 3 == 1 ? -1.0 : 0.0, i % 3 == 2 ? 1.0 : -0.0};
    if (i % 8 == 3) direction[i % 3] = 1e-30;
    if (const auto ray = geometry::make_local_ray(target - direction * distance, direction))
      rays.push_back(*ray);
  }
  return rays;
}

struct Kept {
  std::size_t met = 0, kept = 0, all = 0;
};

/// Batches of all sizes, and limits behind, inside and before the boxes.
Kept filter(const std::vector<Reference>& boxes, const std::vector<LocalRay>& rays) {
  Aabb bounds;
  for (const Reference& box : boxes) bounds.grow(box.bounds());
  Kept sum;
  std::size_t size = 1;
  for (const LocalRay& ray : rays) {
    TreeRay in_tree;
    if (!enter(ray, bounds, 0, std::numeric_limits<double>::max(), in_tree)) continue;
    for (const double share : {2.0, 0.5}) {
      const double limit = in_tree.t_in + (in_tree.t_out - in_tree.t_in) * share;
      FilterRay filtered = filter_ray(in_tree);
      end_at(filtered, limit);
      for (std::size_t begin = 0; begin < boxes.size(); size = size % kFilterBatch + 1) {
        const auto batch = std::span(boxes).subspan(begin, std::min(size, boxes.size() - begin));
        const std::uint64_t mask = may_meet_mask(filtered, batch);
        EXPECT_TRUE(batch.size() == kFilterBatch || mask >> batch.size() == 0);
        for (std::size_t i = 0; i < batch.size(); ++i) {
          const bool met = may_meet(in_tree, batch[i].bounds(), limit);
          const bool kept = (mask >> i & 1) != 0;
          EXPECT_TRUE(kept || !met) << "box " << begin + i;
          sum.met += met ? 1 : 0;
          sum.kept += kept ? 1 : 0;
          ++sum.all;
        }
        begin += batch.size();
      }
    }
  }
  return sum;
}

using BoxFilter = tests::OnSimdTarget;

TEST_P(BoxFilter, KeepsWhatMayBeMetAndLittleElse) {
  for (const double size : {1.0, 1e-3, 1e8}) {
    for (const double distance : {0.1, 10.0, 1000.0}) {
      const auto boxes = random_boxes(300, size, {size, -3 * size, 0}, 1);
      const Kept kept = filter(boxes, rays_at(boxes, distance * size, 2));
      EXPECT_GT(kept.met, 0u);
      if (GetParam() == HWY_SCALAR) continue;
      EXPECT_LE(kept.kept - kept.met, kept.all / 50) << size << " from " << distance;
    }
  }
}

TEST_P(BoxFilter, KeepsWhatMayBeMetWhereFloatsAreCoarse) {
  for (const double far : {1e3, 1e5, 1e7, 1e12, 1e37}) {
    const auto boxes = random_boxes(200, far / 100, {far, -far / 3, far / 7}, 3);
    filter(boxes, rays_at(boxes, far / 10, 4));
    filter(boxes, rays_at(boxes, far * 10, 5));
  }
}

TEST_P(BoxFilter, KeepsWhatMayBeMetAtTheEndsOfTheRange) {
  for (const double size : {1e38, 3e37, 1e19, 1e-20, 1e-30, 1e-37, 1e-42}) {
    const auto boxes = random_boxes(200, size, {}, 6);
    for (const double distance : {0.5, 3.0, 1e6, 1e60})
      filter(boxes, rays_at(boxes, distance * size, 7));
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, BoxFilter, tests::every_simd_target(), tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::kdtree
