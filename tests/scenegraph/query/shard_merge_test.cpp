// The answers of the shards together are those of the whole scene.
#include "scenegraph/query/shard_merge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/query/three_shards.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/hard_points.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using tests::Frames;
using tests::IsLost;
using tests::KindAnswers;
using tests::kNoneLost;
using tests::put_node;
using tests::three_cubes;

using SnapshotPointer = std::shared_ptr<const revision::Snapshot>;
/// The servers of the shards, in this process.
class Shards {
 public:
  Shards(SnapshotPointer snapshot, std::uint32_t shards)
      : snapshot_(std::move(snapshot)), cut_(std::make_shared<const ShardCut>(*snapshot_, shards)) {
    for (std::uint32_t i = 0; i < shards; ++i)
      selections_.push_back(*Selection::make(snapshot_, 0, {}, {}, {cut_, i}));
  }

  ShardMerge ask(QueryKind kind, std::span<const Ray> rays, TraceOptions options,
                 const IsLost& is_lost = kNoneLost) {
    options.kind = kind;
    ShardMerge merge;
    merge.begin(*cut_, kind, rays, options.max_hits, options.points);
    for (auto questions = merge.next(); !questions.empty(); questions = merge.next()) {
      for (const ShardQuestion& question : questions) {
        questions_ += question.rays.size();
        if (is_lost(question.shard)) {
          merge.lose(question);
        } else {
          answer(question, options, merge);
        }
      }
    }
    return merge;
  }

  KindAnswers ask_all(std::span<const Ray> rays, const TraceOptions& options) {
    KindAnswers answers;
    const auto set = [](auto& to, const auto& from) { to.assign(from.begin(), from.end()); };
    set(answers.closest, ask(QueryKind::kClosest, rays, options).hits());
    set(answers.any, ask(QueryKind::kAny, rays, options).hits());
    set(answers.counts, ask(QueryKind::kCount, rays, options).tallies());
    const ShardMerge lists = ask(QueryKind::kAll, rays, options);
    set(answers.lists, lists.tallies());
    set(answers.listed, lists.listed());
    return answers;
  }

  const ShardCut& cut() const { return *cut_; }
  /// Rays that shards were asked for.
  std::uint64_t questions() const { return questions_; }

 private:
  void answer(const ShardQuestion& question, TraceOptions options, ShardMerge& merge) {
    options.selection = &selections_[question.shard];
    std::vector<Ray> rays;
    for (const std::uint32_t ray : question.rays) rays.push_back(merge.limited(ray));
    std::vector<Hit> hits(rays.size());
    std::vector<RayTally> tallies(rays.size());
    if (options.kind == QueryKind::kCount) {
      ASSERT_TRUE(count_hits(*snapshot_, rays, tallies, options));
      return merge.take(question, tallies, {});
    }
    if (options.kind == QueryKind::kAll) {
      ASSERT_TRUE(list_hits(*snapshot_, rays, tallies, hits, options));
      return merge.take(question, tallies, hits);
    }
    ASSERT_TRUE(trace(*snapshot_, rays, hits, options));
    merge.take(question, hits);
  }

  SnapshotPointer snapshot_;
  std::shared_ptr<const ShardCut> cut_;
  std::vector<Selection> selections_;
  std::uint64_t questions_ = 0;
};

/// All that is not work, bit for bit.
auto bits(const Hit& hit) {
  const auto word = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return std::array<std::uint64_t, 9>{std::bit_cast<std::uint64_t>(hit.t),
                                      hit.node,
                                      hit.primitive,
                                      word(hit.u),
                                      word(hit.v),
                                      word(hit.normal.x),
                                      word(hit.normal.y),
                                      word(hit.normal.z),
                                      static_cast<std::uint64_t>(hit.state)};
}
auto bits(const RayTally& tally) {
  return std::array<std::uint64_t, 3>{tally.count, static_cast<std::uint64_t>(tally.state),
                                      tally.cut_off ? 1u : 0u};
}

template <class Row>
void expect_equal(const std::vector<Row>& whole, const std::vector<Row>& merged, const char* kind) {
  ASSERT_EQ(whole.size(), merged.size()) << kind;
  for (std::size_t i = 0; i < whole.size(); ++i)
    ASSERT_EQ(bits(whole[i]), bits(merged[i])) << kind << " " << i;
}

void expect_equal(const KindAnswers& whole, const KindAnswers& merged) {
  expect_equal(whole.closest, merged.closest, "closest");
  expect_equal(whole.any, merged.any, "any");
  expect_equal(whole.counts, merged.counts, "counts");
  expect_equal(whole.lists, merged.lists, "lists");
  expect_equal(whole.listed, merged.listed, "listed");
}

void expect_shards_as_whole(const SnapshotPointer& snapshot, std::span<const Ray> rays,
                            const TraceOptions& options = {}) {
  const KindAnswers whole = tests::ask_all_kinds(*snapshot, rays, options);
  for (const std::uint32_t shards : {1u, 2u, 3u, 7u, kMaxShards}) {
    SCOPED_TRACE(shards);
    Shards cut(snapshot, shards);
    expect_equal(whole, cut.ask_all(rays, options));
  }
}

/// Some invalid, with limits and masks.
std::vector<Ray> rays_to_merge(const revision::Snapshot& snapshot, std::uint64_t seed) {
  std::vector<Ray> rays = tests::rays_through(snapshot, 300, seed);
  tests::Random random(seed);
  for (std::size_t i = 0; i < rays.size(); i += 3) {
    rays[i].tmax = random.uniform(0, 1.5);
    rays[i].tmin = random.uniform(-0.5, 0.5);
    rays[i].mask = static_cast<std::uint32_t>(random.below(8));
  }
  rays[5].direction = {};
  rays[6].origin.y = std::nan("");
  rays[7].tmax = std::nan("");
  rays[8].tmax = -1;
  return rays;
}

TEST(ShardMerge, IsAsTheWholeSceneForRandomHierarchies) {
  for (const Frames frames : {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat}) {
    SCOPED_TRACE(static_cast<int>(frames));
    const auto snapshot = tests::snapshot_of(tests::random_hierarchy(60, frames, 11));
    expect_shards_as_whole(snapshot, rays_to_merge(*snapshot, 3), {.max_hits = 5});
  }
}

/// Equal t in several shards: node and primitive decide, as within one tree.
TEST(ShardMerge, IsAsTheWholeSceneForCoincidentFaces) {
  const auto cube = tests::mesh_of(tests::cube()), twice = tests::mesh_of(tests::duplicates(3));
  std::vector<model::Update> updates;
  for (int i = 1; i <= 12; ++i) updates.emplace_back(put_node(-i, 0, i % 4 == 0 ? twice : cube));
  const auto snapshot = tests::snapshot_of(updates);
  expect_shards_as_whole(snapshot, rays_to_merge(*snapshot, 5), {.max_hits = 3});
  const ShardCut cut(*snapshot, 3);
  EXPECT_EQ(cut.shard_of(1), 0u);
  EXPECT_EQ(cut.shard_of(12), 2u) << "ties are in different shards";
}

TEST(ShardMerge, IsAsTheWholeSceneWhereFacesTouch) {
  const auto snapshot = tests::tiled_plane(64, 4);
  std::vector<Ray> rays;
  for (int x = 0; x <= 16; ++x) {
    for (int y = 0; y <= 16; ++y)
      rays.push_back({.origin = {x * 0.5, y * 0.5, 3}, .direction = {0, 0, -1}});
  }
  expect_shards_as_whole(snapshot, rays);
}

TEST(ShardMerge, IsAsTheWholeSceneAfterMovesToAndFro) {
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, Frames::kRigid, 4)));
  tests::Random random(8);
  for (int step = 0; step < 6; ++step) {
    model::SetTransforms moves;
    for (int i = 0; i < 5; ++i) {
      moves.nodes.push_back(static_cast<model::NodeRef>(1 + random.below(60)));
      moves.parent_from_local.push_back(tests::random_frame(random, Frames::kFar, 8));
    }
    ASSERT_TRUE(scene.apply({moves}));
    expect_shards_as_whole(scene.snapshot(), rays_to_merge(*scene.snapshot(), 3));
  }
}

TEST(ShardMerge, IsAsTheWholeSceneForCulledFaces) {
  const auto snapshot = tests::snapshot_of(tests::random_hierarchy(60, Frames::kSheared, 21));
  expect_shards_as_whole(snapshot, rays_to_merge(*snapshot, 4),
                         {.culling = accel::geometry::Culling::kBack});
}

TEST(ShardMerge, IsAsTheWholeSceneForPoints) {
  for (const Frames frames : {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat}) {
    SCOPED_TRACE(static_cast<int>(frames));
    const auto snapshot = tests::snapshot_of(tests::random_hierarchy(60, frames, 13));
    std::vector<Ray> points;
    tests::Random random(6);
    for (const accel::geometry::Vec3d& at : tests::hard_points(*snapshot, 14, tests::rounds(80))) {
      points.push_back({.origin = at, .direction = {1, 0, 0}});
      if (random.below(3) == 0) points.back().tmax = random.uniform(-0.1, 3);
      if (random.below(4) == 0) points.back().mask = static_cast<std::uint32_t>(random.below(8));
    }
    points[5].origin.y = std::nan("");
    points[6].tmax = std::nan("");
    expect_shards_as_whole(snapshot, points, {.points = true, .max_hits = 5});
  }
}

TEST(ShardMerge, IsAsTheWholeSceneWithoutInstances) {
  const auto snapshot = tests::snapshot_of({put_node(-1, 0, nullptr)});
  const std::vector<Ray> rays{{.origin = {0, 0, 0}, .direction = {1, 0, 0}},
                              {.origin = {0, 0, 0}, .direction = {0, 0, 0}}};
  expect_shards_as_whole(snapshot, rays);
}

/// Through all cubes; through the first to the right; over all; through the last alone.
const std::vector<Ray> kThroughCubes{{.origin = {-5, 0.1, 0.2}, .direction = {1, 0, 0}},
                                     {.origin = {5, 0.1, 0.2}, .direction = {1, 0, 0}},
                                     {.origin = {-5, 5, 0}, .direction = {1, 0, 0}},
                                     {.origin = {20.3, 0.1, 5}, .direction = {0, 0, -1}}};

TEST(ShardMerge, AsksForNoMoreThanRaysNeed) {
  Shards shards(three_cubes(), 3);
  static_cast<void>(shards.ask(QueryKind::kClosest, kThroughCubes, {}));
  EXPECT_EQ(shards.questions(), 3u) << "the nearest cube of each";
  static_cast<void>(shards.ask(QueryKind::kAny, kThroughCubes, {}));
  EXPECT_EQ(shards.questions(), 6u);
  static_cast<void>(shards.ask(QueryKind::kCount, kThroughCubes, {}));
  EXPECT_EQ(shards.questions(), 12u) << "3 + 2 + 0 + 1";
}

std::vector<HitState> states(std::span<const Hit> hits) {
  std::vector<HitState> states;
  for (const Hit& hit : hits) states.push_back(hit.state);
  return states;
}
std::vector<HitState> states(std::span<const RayTally> tallies) {
  std::vector<HitState> states;
  for (const RayTally& tally : tallies) states.push_back(tally.state);
  return states;
}

TEST(ShardMerge, LeavesRaysUnansweredThatALostShardCouldChange) {
  using enum HitState;
  Shards shards(three_cubes(), 3);
  const IsLost second = [](std::uint32_t shard) { return shard == 1; };
  const ShardMerge closest = shards.ask(QueryKind::kClosest, kThroughCubes, {}, second);
  EXPECT_EQ(states(closest.hits()), (std::vector{kHit, kUnanswered, kMiss, kHit}));
  EXPECT_EQ(closest.hits()[1].t, -accel::geometry::kInfinity);
  EXPECT_EQ(closest.hits()[1].node, 0u);
  EXPECT_EQ(closest.stats().unanswered, 1u);
  EXPECT_EQ(closest.stats().rays, 3u);
  EXPECT_EQ(closest.stats().hits, 2u);
  const ShardMerge any = shards.ask(QueryKind::kAny, kThroughCubes, {}, second);
  EXPECT_EQ(states(any.hits()), (std::vector{kHit, kHit, kMiss, kHit})) << "another one has a hit";
  const ShardMerge count = shards.ask(QueryKind::kCount, kThroughCubes, {}, second);
  EXPECT_EQ(states(count.tallies()), (std::vector{kUnanswered, kUnanswered, kMiss, kHit}));
  EXPECT_EQ(count.tallies()[0].count, kUnansweredCount);
  const ShardMerge all = shards.ask(QueryKind::kAll, kThroughCubes, {}, second);
  EXPECT_EQ(states(all.tallies()), (std::vector{kUnanswered, kUnanswered, kMiss, kHit}));
  EXPECT_EQ(all.listed().size(), 2u);
  EXPECT_EQ(all.stats().hits_found, 2u);
  const ShardMerge none =
      shards.ask(QueryKind::kAny, kThroughCubes, {}, [](std::uint32_t) { return true; });
  EXPECT_EQ(states(none.hits()), (std::vector{kUnanswered, kUnanswered, kMiss, kUnanswered}));
}

}  // namespace
}  // namespace sightline::scenegraph::query
