// Frustums through wide nodes over slots: finished ones, and ones that are not.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "accel/wide/frustum.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_in_parts.h"

namespace sightline::accel::wide {
namespace {

using geometry::Ray;
using tests::Answer;
using tests::MeshInParts;
using tests::search;

class FrustumSlots : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, FrustumSlots, tests::every_simd_target(), tests::simd_target_name);

/// One packet.
struct FrustumWalk {
  FrustumWalk(std::span<const Ray> rays, bool any) {
    best->clear();
    packet->best = best.get();
    packet->goal = any ? Goal::kAny : Goal::kNearest;
    packet->node = 1;
    packet->work.fill(0);
    tests::set_rays(rays, packet->rays);
  }

  Answer answer(std::size_t lane) const {
    const bool found = (best->found >> lane & 1) != 0;
    if (!found || packet->goal == Goal::kAny) return {found};
    return {true, best->t[lane], best->primitive[lane]};
  }

  std::unique_ptr<Packet> packet = std::make_unique<Packet>();
  std::unique_ptr<BestHits> best = std::make_unique<BestHits>();
};

/// The rays of a camera.
std::vector<Ray> frustum(double aim) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const double x = static_cast<double>(i) / kLanes;
    rays.push_back({{0.5, 0.5, -2}, {0.4 * (x - aim), 0.3 * (aim - x * x), 2}});
  }
  return rays;
}

/// Whether all rays are done; else none is.
bool is_done_as_frustum(const MeshInParts& parts, Child root, std::span<const Ray> rays,
                        FrustumWalk& walk) {
  FrustumLanes lanes{};
  lanes[0] = (1u << rays.size()) - 1;
  kdtree::WalkCounters walked;
  const FrustumLanes done =
      walk_frustum({walk.packet.get(), 1}, parts.of.frame, root, lanes, walked);
  EXPECT_TRUE(done == lanes || done == FrustumLanes{});
  return done == lanes;
}

TEST_P(FrustumSlots, GoThroughFinishedOnesAndPassEmptyLeaves) {
  for (const bool any : {false, true}) {
    for (const double aim : {0.0, 0.5, 1.0}) {
      MeshInParts parts(tests::random_soup(80, 0.2, 3), 9);
      const auto is_finished = [](std::size_t part) { return part % 3 != 1; };
      for (std::size_t part = 0; part < parts.slots.size(); ++part) {
        is_finished(part) ? parts.finish(part) : parts.empty(part);
      }
      const std::vector<Ray> rays = frustum(aim);
      FrustumWalk walk(rays, any);
      ASSERT_TRUE(is_done_as_frustum(parts, parts.root(), rays, walk));
      for (std::size_t lane = 0; lane < rays.size(); ++lane)
        ASSERT_EQ(walk.answer(lane), search(parts, rays[lane], any, is_finished));
    }
  }
}

// A part that is no leaf yet: a frustum that goes on past it has no better hit there.
TEST_P(FrustumSlots, EndAtOnesThatAreNotFinished) {
  std::size_t done = 0, not_done = 0;
  for (const bool any : {false, true}) {
    for (const double aim : {-2.0, 0.0, 0.5, 1.0, 3.0}) {
      for (std::size_t open = 0; open < 40; ++open) {
        MeshInParts parts(tests::random_soup(200, 0.05, 3), 40);
        for (std::size_t part = 0; part < parts.slots.size(); ++part) parts.finish(part);
        parts.open(open);
        const std::vector<Ray> rays = frustum(aim);
        FrustumWalk walk(rays, any);
        if (!is_done_as_frustum(parts, parts.root(), rays, walk)) {
          ++not_done;
          if (any) continue;
          for (std::size_t lane = 0; lane < rays.size(); ++lane)
            ASSERT_EQ(walk.answer(lane), Answer{});
          continue;
        }
        ++done;
        for (std::size_t lane = 0; lane < rays.size(); ++lane)
          ASSERT_EQ(walk.answer(lane),
                    search(parts, rays[lane], any, [](std::size_t) { return true; }));
      }
    }
  }
  EXPECT_GT(done, 20u);
  EXPECT_GT(not_done, 20u);
}

TEST_P(FrustumSlots, ARootMayBeASlot) {
  MeshInParts parts(tests::random_soup(80, 0.2, 3), 2);
  const std::vector<Ray> rays = frustum(0.5);
  for (const bool any : {false, true}) {
    parts.empty(0);
    FrustumWalk empty(rays, any);
    EXPECT_TRUE(is_done_as_frustum(parts, Child::at(*parts.slots[0]), rays, empty));
    EXPECT_EQ(empty.best->found, 0u);
    parts.open(0);
    FrustumWalk open(rays, any);
    EXPECT_FALSE(is_done_as_frustum(parts, Child::at(*parts.slots[0]), rays, open));
    EXPECT_EQ(open.best->found, 0u);
    parts.finish(0);
    FrustumWalk walk(rays, any);
    ASSERT_TRUE(is_done_as_frustum(parts, Child::at(*parts.slots[0]), rays, walk));
    for (std::size_t lane = 0; lane < rays.size(); ++lane) {
      const auto is_first = [](std::size_t part) { return part == 0; };
      ASSERT_EQ(walk.answer(lane), search(parts, rays[lane], any, is_first));
    }
  }
}

}  // namespace
}  // namespace sightline::accel::wide
