// Batches that end early: rays without an answer are marked, and asking again goes on from there.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/random_hierarchy.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

constexpr std::size_t kRays = 1500;

std::shared_ptr<const revision::Snapshot> cold_scene() {
  return tests::snapshot_of(tests::random_hierarchy(200, tests::Frames::kRigid, 3));
}

TraceOptions partial(const std::atomic<bool>& stopped, QueryKind kind = QueryKind::kClosest) {
  TraceOptions options;
  options.kind = kind;
  options.cancelled = &stopped;
  options.partial = true;
  return options;
}

bool same(const Hit& a, const Hit& b) {
  return a.t == b.t && a.node == b.node && a.primitive == b.primitive && a.u == b.u && a.v == b.v &&
         a.normal == b.normal && a.state == b.state;
}

TEST(Partial, WithoutTimeAllRaysAreMarked) {
  const auto snapshot = cold_scene();
  const std::vector<Ray> rays = tests::rays_through(*snapshot, kRays, 4);
  const std::atomic<bool> stopped{true};
  std::vector<Hit> hits(kRays);
  const auto traced = trace(*snapshot, rays, hits, partial(stopped));
  ASSERT_TRUE(traced) << traced.error().message;
  EXPECT_EQ(traced->rays, 0u);
  EXPECT_EQ(traced->unanswered, kRays);
  for (const Hit& hit : hits) {
    ASSERT_EQ(hit.state, HitState::kUnanswered);
    ASSERT_EQ(hit.t, -std::numeric_limits<double>::infinity());
    ASSERT_EQ(hit.node, 0u);
  }
  TraceOptions full = partial(stopped);
  full.growth = Growth::kFull;
  const auto built = trace(*snapshot, rays, hits, full);
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->unanswered, kRays);
}

TEST(Partial, CountsAndListsAreMarked) {
  const auto snapshot = cold_scene();
  const std::vector<Ray> rays = tests::rays_through(*snapshot, kRays, 5);
  const std::atomic<bool> stopped{true};
  std::vector<RayTally> tallies(kRays);
  const auto counted = count_hits(*snapshot, rays, tallies, partial(stopped));
  ASSERT_TRUE(counted);
  EXPECT_EQ(counted->unanswered, kRays);
  EXPECT_TRUE(std::ranges::all_of(tallies, [](const RayTally& tally) {
    return tally.state == HitState::kUnanswered && tally.count == kUnansweredCount;
  }));
  std::vector<Hit> hits;
  const auto listed = list_hits(*snapshot, rays, tallies, hits, partial(stopped));
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->unanswered, kRays);
  EXPECT_TRUE(hits.empty());
  EXPECT_TRUE(std::ranges::all_of(tallies, [](const RayTally& tally) {
    return tally.state == HitState::kUnanswered && tally.count == 0;
  }));
}

TEST(Partial, WithEnoughTimeNothingIsMarked) {
  const auto snapshot = cold_scene();
  const std::vector<Ray> rays = tests::rays_through(*snapshot, kRays, 6);
  const std::atomic<bool> stopped{false};
  std::vector<Hit> hits(kRays);
  const auto traced = trace(*snapshot, rays, hits, partial(stopped));
  ASSERT_TRUE(traced);
  EXPECT_EQ(traced->rays, kRays);
  EXPECT_EQ(traced->unanswered, 0u);
}

/// Stopped at any moment, each ray has its full answer or a mark.
TEST(Partial, AnAnswerIsFullOrMarked) {
  const auto reference = cold_scene();
  const std::vector<Ray> rays = tests::rays_through(*reference, kRays, 7);
  std::vector<Hit> expected(kRays);
  ASSERT_TRUE(trace(*reference, rays, expected, {}));
  std::vector<RayTally> counts(kRays);
  ASSERT_TRUE(count_hits(*reference, rays, counts, {}));
  for (int pause = 0; pause < 12; ++pause) {
    const auto snapshot = cold_scene();
    std::atomic<bool> stopped{false};
    std::thread stopping([&] {
      for (int i = 0; i < pause * 80; ++i) std::this_thread::yield();
      stopped = true;
    });
    std::vector<Hit> hits(kRays);
    const auto traced = trace(*snapshot, rays, hits, partial(stopped));
    std::vector<RayTally> tallies(kRays);
    const auto counted = count_hits(*snapshot, rays, tallies, partial(stopped));
    stopping.join();
    ASSERT_TRUE(traced && counted);
    std::size_t marked = 0;
    for (std::size_t i = 0; i < kRays; ++i) {
      if (hits[i].state == HitState::kUnanswered) {
        ++marked;
      } else {
        ASSERT_TRUE(same(hits[i], expected[i])) << "ray " << i;
      }
      if (tallies[i].state != HitState::kUnanswered) {
        ASSERT_EQ(tallies[i].count, counts[i].count) << "ray " << i;
      }
    }
    EXPECT_EQ(traced->unanswered, marked);
    EXPECT_EQ(traced->rays, kRays - marked);
  }
}

/// What was built stays, so that asking again ends.
TEST(Partial, AskingAgainGoesOn) {
  const auto snapshot = cold_scene();
  const std::vector<Ray> rays = tests::rays_through(*snapshot, kRays, 8);
  std::vector<Hit> expected(kRays), hits(kRays);
  ASSERT_TRUE(trace(*cold_scene(), rays, expected, {}));
  std::vector<Ray> left = rays;
  std::vector<std::size_t> rows(kRays);
  for (std::size_t i = 0; i < kRays; ++i) rows[i] = i;
  for (int yields = 1; !left.empty(); yields *= 2) {
    std::atomic<bool> stopped{false};
    std::thread stopping([&] {
      for (int i = 0; i < yields; ++i) std::this_thread::yield();
      stopped = true;
    });
    std::vector<Hit> part(left.size());
    const auto traced = trace(*snapshot, left, part, partial(stopped));
    stopping.join();
    ASSERT_TRUE(traced);
    std::vector<Ray> next;
    std::vector<std::size_t> next_rows;
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (part[i].state == HitState::kUnanswered) {
        next.push_back(left[i]);
        next_rows.push_back(rows[i]);
      } else {
        hits[rows[i]] = part[i];
      }
    }
    left = std::move(next);
    rows = std::move(next_rows);
  }
  for (std::size_t i = 0; i < kRays; ++i) ASSERT_TRUE(same(hits[i], expected[i])) << "ray " << i;
}

}  // namespace
}  // namespace sightline::scenegraph
