// The sides that the shards answer together are those of the whole scene.
#include "scenegraph/query/shard_sides.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/sides.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/query/three_shards.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/hard_points.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using tests::Frames;
using tests::IsLost;
using tests::kNoneLost;
using tests::put_node;
using tests::TestMesh;
using tests::three_cubes;

using SharedRevision = std::shared_ptr<const revision::Snapshot>;

const std::array<SideQuestion, 7> kQuestions{{{SideRule::kParity, 1},
                                              {SideRule::kParity, 7},
                                              {SideRule::kParity, kMaxSideRays},
                                              {SideRule::kWinding, 1},
                                              {SideRule::kWinding, 7},
                                              {SideRule::kWinding, kMaxSideRays},
                                              {SideRule::kNormal, 1}}};

struct MergedSides {
  std::vector<Side> sides;
  std::vector<std::uint8_t> votes;

  friend bool operator==(const MergedSides&, const MergedSides&) = default;
};

MergedSides find_whole(const revision::Snapshot& snapshot, std::span<const Ray> points,
                       const SideQuestion& question) {
  MergedSides found{std::vector<Side>(points.size()), std::vector<std::uint8_t>(points.size())};
  EXPECT_TRUE(find_sides(snapshot, accel::geometry::columns_of(points), question,
                         {found.sides, found.votes}, {}));
  if (question.rule == SideRule::kNormal) found.votes.assign(points.size(), 0);
  return found;
}

/// The servers of the shards, in this process.
class SideShards {
 public:
  SideShards(SharedRevision snapshot, std::uint32_t shards)
      : snapshot_(std::move(snapshot)), cut_(std::make_shared<const ShardCut>(*snapshot_, shards)) {
    for (std::uint32_t i = 0; i < shards; ++i)
      selections_.push_back(*Selection::make(snapshot_, 0, {}, {}, {cut_, i}));
  }

  MergedSides ask(std::span<const Ray> points, const SideQuestion& question,
                  const IsLost& is_lost = kNoneLost) {
    ShardSides merge;
    const std::vector<Hit> nearest = nearest_of(points);
    merge.begin(*cut_, question, points, nearest);
    for (auto asked = merge.next(); !asked.empty(); asked = merge.next()) {
      ++rounds_;
      for (const ShardQuestion& of_shard : asked) {
        questions_ += of_shard.rays.size();
        if (is_lost(of_shard.shard)) {
          merge.lose(of_shard);
        } else {
          answer(points, of_shard, question, merge);
        }
      }
    }
    const auto sides = merge.sides();
    const auto votes = merge.votes();
    return {{sides.begin(), sides.end()}, {votes.begin(), votes.end()}};
  }

  /// Points that shards were asked for, and how often shards were asked.
  std::uint64_t questions() const { return questions_; }
  std::uint64_t rounds() const { return rounds_; }

 private:
  std::vector<Hit> nearest_of(std::span<const Ray> points) const {
    std::vector<Ray> unlimited(points.begin(), points.end());
    for (Ray& point : unlimited) {
      if (!std::isnan(point.tmax)) point.tmax = accel::geometry::kInfinity;
    }
    std::vector<Hit> hits(points.size());
    EXPECT_TRUE(trace(*snapshot_, unlimited, hits, {.points = true}));
    return hits;
  }

  void answer(std::span<const Ray> points, const ShardQuestion& asked, const SideQuestion& question,
              ShardSides& merge) {
    std::vector<Ray> some;
    for (const std::uint32_t point : asked.rays) some.push_back(points[point]);
    std::vector<Side> sides(some.size());
    std::vector<std::uint32_t> crossings(
        question.rule == SideRule::kNormal ? 0 : some.size() * question.rays);
    EXPECT_LE(crossings.size(), kMaxCrossings);
    ASSERT_TRUE(find_sides(*snapshot_, accel::geometry::columns_of(std::span<const Ray>(some)),
                           question, {.sides = sides, .crossings = crossings},
                           {.selection = &selections_[asked.shard]}));
    merge.take(asked, sides, crossings);
  }

  SharedRevision snapshot_;
  std::shared_ptr<const ShardCut> cut_;
  std::vector<Selection> selections_;
  std::uint64_t questions_ = 0, rounds_ = 0;
};

void expect_sides_as_whole(const SharedRevision& snapshot, std::span<const Ray> points) {
  for (const SideQuestion& question : kQuestions) {
    SCOPED_TRACE(static_cast<int>(question.rule));
    SCOPED_TRACE(question.rays);
    const MergedSides whole = find_whole(*snapshot, points, question);
    for (const std::uint32_t shards : {1u, 2u, 7u, kMaxShards}) {
      SCOPED_TRACE(shards);
      const MergedSides merged = SideShards(snapshot, shards).ask(points, question);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(merged.sides[i], whole.sides[i]) << i;
        ASSERT_EQ(merged.votes[i], whole.votes[i]) << i;
      }
    }
  }
}

/// Some invalid, with limits and masks.
std::vector<Ray> points_to_merge(const revision::Snapshot& snapshot, std::uint64_t seed) {
  std::vector<Ray> points;
  tests::Random random(seed);
  for (const Vec3d& at : tests::hard_points(snapshot, seed, tests::rounds(120))) {
    points.push_back({.origin = at, .direction = {1, 0, 0}});
    if (random.below(3) == 0) points.back().tmax = random.uniform(-0.1, 3);
    if (random.below(4) == 0) points.back().mask = static_cast<std::uint32_t>(random.below(8));
  }
  points[5].origin.y = std::nan("");
  points[6].tmax = std::nan("");
  points[7].origin.z = 0x1p+251;
  return points;
}

std::vector<Ray> points_at(std::span<const Vec3d> at) {
  std::vector<Ray> points;
  for (const Vec3d& p : at) points.push_back({.origin = p, .direction = {1, 0, 0}});
  return points;
}

SharedRevision nodes_of(std::span<const TestMesh> meshes) {
  std::vector<model::Update> updates;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    updates.emplace_back(put_node(-1 - static_cast<int>(i), 0, tests::mesh_of(meshes[i])));
  return tests::snapshot_of(updates);
}

TEST(ShardSides, AreThoseOfTheWholeSceneForRandomHierarchies) {
  for (const Frames frames : {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat}) {
    SCOPED_TRACE(static_cast<int>(frames));
    const auto snapshot = tests::snapshot_of(tests::random_hierarchy(60, frames, 11));
    expect_sides_as_whole(snapshot, points_to_merge(*snapshot, 3));
  }
}

/// Every point is on a plane of faces, and most are on faces, edges and corners of several shards.
TEST(ShardSides, AreThoseOfTheWholeSceneForABlockOfBoxes) {
  std::vector<TestMesh> boxes;
  for (int i = 0; i < 27; ++i) {
    const Vec3f lo{static_cast<float>(i % 3), static_cast<float>(i / 3 % 3),
                   static_cast<float>(i / 9)};
    boxes.push_back(tests::box(lo, lo + Vec3f{1, 1, 1}));
  }
  std::vector<Vec3d> at;
  for (int i = 0; i < 343; ++i) at.push_back({i % 7 * 0.5, i / 7 % 7 * 0.5, i / 49 * 0.5});
  const auto snapshot = nodes_of(boxes);
  expect_sides_as_whole(snapshot, points_at(at));
  const MergedSides found = SideShards(snapshot, 5).ask(points_at(at), {SideRule::kWinding, 1});
  for (std::size_t i = 0; i < at.size(); ++i) {
    const bool within = at[i].x < 3 && at[i].y < 3 && at[i].z < 3;
    EXPECT_EQ(found.sides[i], within ? Side::kInside : Side::kOutside) << i;
  }
}

TEST(ShardSides, AreThoseOfTheWholeSceneForBoxesThatOverlap) {
  const std::vector<TestMesh> boxes{tests::box({0, 0, 0}, {2, 2, 2}),
                                    tests::box({1, 1, 1}, {3, 3, 3}),
                                    tests::box({1, 1, 1}, {2, 2, 2})};
  const auto snapshot = nodes_of(boxes);
  expect_sides_as_whole(snapshot, points_to_merge(*snapshot, 9));
}

/// A sphere whose faces are in nodes of their own, so that no shard has a closed mesh.
TEST(ShardSides, AreThoseOfTheWholeSceneForPartsOfASphere) {
  const TestMesh sphere = tests::icosphere(2);
  std::vector<TestMesh> parts(40);
  for (std::size_t i = 0; i < sphere.faces.size(); ++i) {
    parts[i % parts.size()].vertices = sphere.vertices;
    parts[i % parts.size()].faces.push_back(sphere.faces[i]);
  }
  const auto snapshot = nodes_of(parts);
  expect_sides_as_whole(snapshot, points_to_merge(*snapshot, 4));
  const std::vector<Ray> middle = points_at(std::vector<Vec3d>{{0, 0, 0}});
  EXPECT_EQ(SideShards(snapshot, 7).ask(middle, {SideRule::kParity, kMaxSideRays}),
            (MergedSides{{Side::kInside}, {kMaxSideRays}}));
}

TEST(ShardSides, AreThoseOfTheWholeSceneAfterMovesToAndFro) {
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, Frames::kRigid, 4)));
  tests::Random random(8);
  for (int step = 0; step < 3; ++step) {
    model::SetTransforms moves;
    for (int i = 0; i < 5; ++i) {
      moves.nodes.push_back(static_cast<model::NodeRef>(1 + random.below(60)));
      moves.parent_from_local.push_back(tests::random_frame(random, Frames::kFar, 8));
    }
    ASSERT_TRUE(scene.apply({moves}));
    expect_sides_as_whole(scene.snapshot(), points_to_merge(*scene.snapshot(), 3));
  }
}

TEST(ShardSides, AreThoseOfTheWholeSceneWithoutInstances) {
  const auto snapshot = tests::snapshot_of({put_node(-1, 0, nullptr)});
  expect_sides_as_whole(snapshot, points_at(std::vector<Vec3d>{{0, 0, 0}, {std::nan(""), 0, 0}}));
}

TEST(ShardSides, AreAskedInPartsSoThatAnswersAreBounded) {
  std::vector<Vec3d> at;
  for (int i = 0; i < 9'000; ++i) at.push_back({i * 0.002, 0.1, 0.2});
  const std::vector<Ray> points = points_at(at);
  const auto snapshot = three_cubes();
  SideShards shards(snapshot, 3);
  const SideQuestion question{SideRule::kWinding, kMaxSideRays};
  EXPECT_EQ(shards.ask(points, question), find_whole(*snapshot, points, question));
  EXPECT_EQ(shards.rounds(), 3u) << "of 4,161 points each";
}

TEST(ShardSides, AreAskedOfNoMoreShardsThanNeeded) {
  const std::vector<Ray> points =
      points_at(std::vector<Vec3d>{{0, 0, 0}, {10, 0, 0}, {5, 1000, 0}});
  SideShards shards(three_cubes(), 3);
  static_cast<void>(shards.ask(points, {SideRule::kParity, 1}));
  EXPECT_EQ(shards.questions(), 2u) << "the cube around each";
  static_cast<void>(shards.ask(points, {SideRule::kNormal, 1}));
  EXPECT_EQ(shards.questions(), 5u) << "the nearest cube of each";
}

TEST(ShardSides, AreUnansweredWhereALostShardCouldChangeThem) {
  const std::vector<Ray> points = points_at(std::vector<Vec3d>{
      {0, 0, 0}, {10, 0, 0}, {5, 1000, 0}, {-4, 0, 0}, {8, 0, 0}, {std::nan(""), 0, 0}});
  const IsLost second = [](std::uint32_t shard) { return shard == 1; };
  using enum Side;
  SideShards shards(three_cubes(), 3);
  EXPECT_EQ(shards.ask(points, {SideRule::kParity, 1}, second),
            (MergedSides{{kInside, kUnanswered, kOutside, kOutside, kOutside, kInvalid},
                         {1, 0, 0, 0, 0, 0}}));
  EXPECT_EQ(shards.ask(points, {SideRule::kNormal, 1}, second).sides,
            (std::vector{kInside, kUnanswered, kOutside, kOutside, kUnanswered, kInvalid}));
  const IsLost all = [](std::uint32_t) { return true; };
  EXPECT_EQ(shards.ask(points, {SideRule::kWinding, kMaxSideRays}, all).sides[1], kUnanswered);
}

/// A shard that has had no time answers so.
TEST(ShardSides, AreUnansweredWhereAShardHasNoAnswer) {
  const std::vector<Ray> points = points_at(std::vector<Vec3d>{{0, 0, 0}});
  const ShardCut cut(*three_cubes(), 3);
  ShardSides merge;
  merge.begin(cut, {SideRule::kParity, 1}, points, {});
  const auto asked = merge.next();
  ASSERT_EQ(asked.size(), 1u);
  const std::array<Side, 1> sides{Side::kUnanswered};
  const std::array<std::uint32_t, 1> crossings{1};
  merge.take(asked[0], sides, crossings);
  EXPECT_TRUE(merge.next().empty());
  EXPECT_EQ(merge.sides()[0], Side::kUnanswered);
  EXPECT_EQ(merge.votes()[0], 0);
}

}  // namespace
}  // namespace sightline::scenegraph::query
