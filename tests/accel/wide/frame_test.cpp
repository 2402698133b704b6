// Frames bring trees of all sizes into the range of floats: boxes are met there as they are in
// doubles.
#include "accel/wide/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "accel/wide/float_rays.h"
#include "accel/wide/walk.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::Aabb;
using geometry::Ray;
using geometry::Vec3d;
using tests::Random;

constexpr float kInfinite = std::numeric_limits<float>::infinity();

bool is_in_range(const Frame& frame) {
  const float size = largest_coordinate(frame.bounds);
  return size >= kLeastSize && size <= kLargestSize;
}

Aabb cube(float size) { return {{-size, -size, -size}, {size, size, size}}; }

TEST(Frame, ScalesOnlyWhatIsOutOfRange) {
  for (const float size : {0x1p-40f, 1e-6f, 1.0f, 1e15f, 0x1p+60f}) {
    const Frame frame = frame_of(cube(size));
    EXPECT_EQ(frame.scale, 1) << size;
    EXPECT_EQ(frame.bounds.hi.x, size);
  }
  for (const float size : {0x1p-126f, 0x1p-100f, 1e-20f, 0x1.fffffep-41f, 0x1.000002p+60f, 1e25f,
                           std::numeric_limits<float>::max()}) {
    const Frame frame = frame_of(cube(size));
    EXPECT_TRUE(is_in_range(frame)) << size;
    EXPECT_FALSE(frame.is_boundless);
    EXPECT_EQ(frame.bounds.hi.x, size * frame.scale);
    EXPECT_EQ(std::exp2(std::ilogb(frame.scale)), frame.scale);
    EXPECT_NE(frame.scale, 1);
  }
}

TEST(Frame, OfAnInfiniteTreeIsFinite) {
  for (const Aabb& bounds : {Aabb{{-1, -1, -1}, {1, kInfinite, 1}}, cube(kInfinite)}) {
    const Frame frame = frame_of(bounds);
    EXPECT_TRUE(is_in_range(frame));
    EXPECT_TRUE(frame.is_boundless);
  }
}

/// Boxes in a tree of some size, a hundredth of it each.
std::vector<Aabb> boxes_within(double size, std::size_t count, Random& random) {
  std::vector<Aabb> boxes;
  while (boxes.size() < count) {
    Aabb box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double lo = random.uniform(-size, size);
      box.lo[axis] = geometry::round_down(lo);
      box.hi[axis] = geometry::round_up(lo + 0.01 * size);
    }
    boxes.push_back(box);
  }
  return boxes;
}

/// A ray through a point of the box, from inside the tree, beside it or far away.
Ray ray_through(const Aabb& box, double size, Random& random) {
  Vec3d at, d = random.direction();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lo = static_cast<double>(box.lo[axis]),
                 hi = std::min(static_cast<double>(box.hi[axis]), 0x1p+127);
    at[axis] = lo + (hi - lo) * random.uniform();
  }
  if (random.below(4) == 0) d[random.below(3)] = 0;
  const double distances[] = {0.1, 1, 10, 0x1p+30, 0x1p+62, 0x1p+80};
  return {at - d * (size * distances[random.below(6)]), d};
}

class FrameBoxes : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, FrameBoxes, tests::every_simd_target(), tests::simd_target_name);

TEST_P(FrameBoxes, AreMetInTreesOfAllSizes) {
  Random random(4);
  for (const double size : {1e-37, 1e-20, 1e-13, 1.0, 1e19, 1e25, 1e37, 1e38}) {
    const std::vector<Aabb> boxes = boxes_within(size, 64, random);
    Aabb bounds;
    for (const Aabb& box : boxes) bounds.grow(box);
    const Frame frame = frame_of(bounds);
    auto packet = std::make_unique<Packet>();
    BestHits best;
    packet->best = &best;
    for (int round = 0; round < 50; ++round) {
      std::array<std::size_t, kLanes> through;
      std::vector<Ray> rays;
      for (std::size_t& i : through) {
        i = random.below(boxes.size());
        rays.push_back(ray_through(boxes[i], size, random));
      }
      best.clear();
      tests::set_rays(rays, packet->rays);
      const std::uint32_t live = prepare(*packet, frame, (1u << kLanes) - 1);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Aabb box = in_frame(frame, boxes[through[lane]]);
        EXPECT_NE(meeting(*packet, box, live) >> lane & 1, 0u) << size << " lane " << lane;
      }
    }
  }
}

TEST_P(FrameBoxes, BesideARayAreNotMet) {
  for (const float size : {1e-37f, 1e-20f, 1.0f, 1e25f, 1e38f}) {
    const Frame frame = frame_of(cube(size));
    const double s = static_cast<double>(size);
    const std::vector<Ray> rays{{{-2 * s, 0.5 * s, 0}, {1, 0, 0}}};
    auto packet = std::make_unique<Packet>();
    BestHits best;
    best.clear();
    packet->best = &best;
    tests::set_rays(rays, packet->rays);
    EXPECT_EQ(prepare(*packet, frame, 1), 1u);
    const float y = 0.499f * size, above = 0.501f * size;
    const auto meets = [&](const Aabb& box) { return meeting(*packet, in_frame(frame, box), 1); };
    EXPECT_EQ(meets({{-size, -size, -size}, {size, y, size}}), 0u) << size;
    EXPECT_EQ(meets({{-size, y, -size}, {size, above, size}}), 1u) << size;
  }
}

TEST_P(FrameBoxes, AreAllMetInATreeWithoutBounds) {
  const Frame frame = frame_of({{-1, -1, -1}, {1, kInfinite, 1}});
  Random random(5);
  const float most = std::numeric_limits<float>::max();
  const std::vector<Aabb> boxes{{{-1, -1, -1}, {0, 0, 0}}, {{0, most, 0}, {1, kInfinite, 1}}};
  for (int round = 0; round < 50; ++round) {
    std::vector<Ray> rays;
    while (rays.size() < kLanes) rays.push_back(ray_through(boxes[random.below(2)], 1, random));
    auto packet = std::make_unique<Packet>();
    BestHits best;
    best.clear();
    packet->best = &best;
    tests::set_rays(rays, packet->rays);
    constexpr std::uint32_t kAll = (1u << kLanes) - 1;
    EXPECT_EQ(prepare(*packet, frame, kAll), kAll);
    for (const Aabb& box : boxes) EXPECT_EQ(meeting(*packet, in_frame(frame, box), kAll), kAll);
  }
}

}  // namespace
}  // namespace sightline::accel::wide
