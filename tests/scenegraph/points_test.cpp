// Closest points: every state of the trees, kind and limit gives the faces of the oracle, with the
// same bits of distances.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "scenegraph/query/build.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/accel/simd_targets.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_nearest.h"
#include "tests/support/hard_points.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::BruteNearest;
using tests::Frames;
using tests::NearFace;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<Ray> points_of(std::span<const Vec3d> at, double max_distance = kInfinity) {
  std::vector<Ray> points;
  for (const Vec3d& p : at)
    points.push_back({.origin = p, .direction = {1, 0, 0}, .tmax = max_distance});
  return points;
}

TraceOptions options_of_points() {
  TraceOptions options;
  options.points = true;
  return options;
}

bool is_face(const Hit& hit, const NearFace& face) {
  return hit.t == face.distance && hit.node == face.node && hit.primitive == face.primitive;
}

/// Compares the nearest faces of the points with the oracle's.
void expect_nearest(const revision::Snapshot& snapshot, const BruteNearest& oracle,
                    std::span<const Vec3d> at, const TraceOptions& options) {
  const std::vector<Ray> points = points_of(at);
  std::vector<Hit> hits(points.size());
  ASSERT_TRUE(trace(snapshot, points, hits, options));
  const auto expected = oracle.closest(at, kInfinity);
  for (std::size_t i = 0; i < at.size(); ++i) {
    ASSERT_EQ(hits[i].state == HitState::kHit, expected[i].has_value()) << i;
    if (!expected[i]) continue;
    ASSERT_TRUE(is_face(hits[i], *expected[i]))
        << i << ": (" << at[i].x << ", " << at[i].y << ", " << at[i].z << ") is " << hits[i].t
        << " from " << hits[i].node << ", " << hits[i].primitive << " instead of "
        << expected[i]->distance << " from " << expected[i]->node << ", " << expected[i]->primitive;
  }
}

/// Compares all kinds, within a distance that has some faces, with the oracle and each other.
void expect_kinds(const revision::Snapshot& snapshot, const BruteNearest& oracle,
                  std::span<const Vec3d> at, TraceOptions options) {
  options.max_hits = 5;
  for (const Vec3d& p : at) {
    const auto nearest = oracle.all(p, kInfinity, 9);
    ASSERT_FALSE(nearest.empty());
    for (const double limit : {nearest.back().distance, nearest.front().distance,
                               std::nextafter(nearest.front().distance, -1.0), -1.0, kInfinity}) {
      const std::vector<Ray> point = points_of(std::span(&p, 1), limit);
      const tests::KindAnswers answers = tests::ask_all_kinds(snapshot, point, options);
      EXPECT_EQ(tests::contradiction(answers, options.max_hits), "");
      const auto expected = oracle.all(p, limit);
      ASSERT_EQ(answers.counts[0].count, expected.size());
      ASSERT_EQ(answers.listed.size(), std::min<std::size_t>(expected.size(), options.max_hits));
      for (std::size_t i = 0; i < answers.listed.size(); ++i)
        ASSERT_TRUE(is_face(answers.listed[i], expected[i])) << i;
    }
  }
}

class PointsInFrames : public testing::TestWithParam<Frames> {};

TEST_P(PointsInFrames, EqualTheOracleInEveryStateOfTheTrees) {
  for (const Growth growth : {Growth::kNone, Growth::kFirstTouch, Growth::kDemand, Growth::kFull}) {
    Scene scene;
    ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, GetParam(), 3)));
    const auto snapshot = scene.snapshot();
    const BruteNearest oracle(snapshot);
    TraceOptions options = options_of_points();
    options.growth = growth;
    expect_nearest(*snapshot, oracle, tests::hard_points(*snapshot, 11, tests::rounds(400)),
                   options);
    expect_kinds(*snapshot, oracle, tests::hard_points(*snapshot, 12, tests::rounds(40)), options);
  }
}

TEST_P(PointsInFrames, EqualTheOracleWhenNodesHaveMoved) {
  tests::Random random(7);
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, GetParam(), 5)));
  ASSERT_TRUE(query::build_all(*scene.snapshot(), nullptr, nullptr));
  for (int round = 0; round < 4; ++round) {
    model::SetTransforms moves;
    for (int i = 0; i < 4; ++i) {
      moves.nodes.push_back(static_cast<model::NodeRef>(1 + random.below(60)));
      moves.parent_from_local.push_back(tests::random_frame(random, GetParam()));
    }
    ASSERT_TRUE(scene.apply({moves}));
    const auto snapshot = scene.snapshot();
    const BruteNearest oracle(snapshot);
    expect_nearest(*snapshot, oracle,
                   tests::hard_points(*snapshot, random.next(), tests::rounds(200)),
                   options_of_points());
    expect_kinds(*snapshot, oracle, tests::hard_points(*snapshot, random.next(), tests::rounds(20)),
                 options_of_points());
  }
}

TEST_P(PointsInFrames, SeeTheNodesThatTheirQuerySelects) {
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, GetParam(), 6)));
  const auto snapshot = scene.snapshot();
  ASSERT_TRUE(query::build_all(*snapshot, nullptr, nullptr));
  const std::vector<model::NodeId> excluded{3, 17, 40};
  const auto selection = query::Selection::make(snapshot, 0, excluded);
  ASSERT_TRUE(selection);
  TraceOptions options = options_of_points();
  options.selection = &*selection;
  const auto is_excluded = [&](model::NodeId id) {
    return std::find(excluded.begin(), excluded.end(), id) != excluded.end();
  };
  const tests::NodeFilter filter{.accepts = [&](std::uint64_t node) {
    return !hierarchy::any_upward(snapshot->hierarchy(), node, is_excluded);
  }};
  const BruteNearest oracle(snapshot);
  const std::vector<Vec3d> at = tests::hard_points(*snapshot, 21, 300);
  const std::vector<Ray> points = points_of(at);
  std::vector<Hit> hits(points.size());
  ASSERT_TRUE(trace(*snapshot, points, hits, options));
  const auto expected = oracle.closest(at, kInfinity, filter);
  for (std::size_t i = 0; i < at.size(); ++i) {
    ASSERT_TRUE(expected[i]);
    ASSERT_TRUE(is_face(hits[i], *expected[i])) << i;
  }
}

/// What one point has found must not limit the next one by faces that the query does not see: two
/// surfaces lie in one flat tree, and one of them is excluded.
TEST(Points, SeeOnlyOneOfTwoSurfacesInAFlatTree) {
  Scene scene;
  const tests::TestMesh inner = tests::icosphere(4);
  tests::TestMesh outer = inner;
  for (accel::geometry::Vec3f& v : outer.vertices) v = v * 1.01f;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(inner)),
                           tests::put_node(-2, 0, tests::mesh_of(outer))}));
  const auto snapshot = scene.snapshot();
  ASSERT_TRUE(query::build_all(*snapshot, nullptr, nullptr));
  ASSERT_NE(snapshot->trees().static_tree().flat(), nullptr);
  const BruteNearest oracle(snapshot);
  tests::Random random(17);
  std::vector<Vec3d> at;
  for (int i = 0; i < 400; ++i) at.push_back(random.direction() * random.uniform(0.9, 1.2));
  for (const model::NodeId excluded : {1, 2}) {
    const auto selection = query::Selection::make(snapshot, 0, std::span(&excluded, 1));
    ASSERT_TRUE(selection);
    TraceOptions options = options_of_points();
    options.selection = &*selection;
    const tests::NodeFilter filter{.accepts = [&](std::uint64_t node) { return node != excluded; }};
    std::vector<Hit> hits(at.size());
    ASSERT_TRUE(trace(*snapshot, points_of(at), hits, options));
    const auto expected = oracle.closest(at, kInfinity, filter);
    for (std::size_t i = 0; i < at.size(); ++i) ASSERT_TRUE(is_face(hits[i], *expected[i])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(AllFrames, PointsInFrames,
                         testing::Values(Frames::kRigid, Frames::kSheared, Frames::kFar,
                                         Frames::kFlat));

class PointsOnTarget : public tests::OnSimdTarget {};

TEST_P(PointsOnTarget, EqualTheOracle) {
  for (const tests::TestMesh& mesh :
       {tests::icosphere(4), tests::random_soup(2'000, 0.2, 5), tests::fan(1'024),
        tests::duplicates(300), tests::planar_sheet(24), tests::cube()}) {
    Scene scene;
    ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(mesh), {})}));
    const auto snapshot = scene.snapshot();
    ASSERT_TRUE(query::build_all(*snapshot, nullptr, nullptr));
    expect_nearest(*snapshot, BruteNearest(snapshot),
                   tests::hard_points(*snapshot, 31, tests::rounds(400)), options_of_points());
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, PointsOnTarget, tests::every_simd_target(),
                         tests::simd_target_name);

/// A mesh of faces (i, i, i) is a cloud of points, and (i, j, j) a polyline.
TEST(Points, MeetFacesWithoutArea) {
  tests::Random random(9);
  tests::TestMesh mesh;
  for (std::uint32_t i = 0; i < 3'000; ++i) {
    mesh.vertices.push_back({static_cast<float>(random.uniform()),
                             static_cast<float>(random.uniform()),
                             static_cast<float>(random.uniform())});
    mesh.faces.push_back({i, i, i});
    if (i % 3 == 2) mesh.faces.push_back({i - 1, i, i});
    if (i % 5 == 4) mesh.faces.push_back({i - 2, i - 1, i - 2});
  }
  for (const Growth growth : {Growth::kNone, Growth::kFirstTouch, Growth::kFull}) {
    Scene scene;
    ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(mesh), {})}));
    const auto snapshot = scene.snapshot();
    TraceOptions options = options_of_points();
    options.growth = growth;
    expect_nearest(*snapshot, BruteNearest(snapshot),
                   tests::hard_points(*snapshot, 41, tests::rounds(300)), options);
  }
}

TEST(Points, AreInvalidOrFarAway) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::cube()), {})}));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3d> at{{kNan, 0, 0},     {kInfinity, 0, 0}, {0x1p+251, 0, 0},
                              {0x1p+249, 0, 0}, {0, 0, 3},         {0, 0, 0x1p-300}};
  std::vector<Ray> points = points_of(at);
  points.push_back({.origin = {0, 0, 3}, .direction = {1, 0, 0}, .tmax = kNan});
  std::vector<Hit> hits(points.size());
  ASSERT_TRUE(trace(*scene.snapshot(), points, hits, options_of_points()));
  for (const std::size_t i : {0, 1, 2, 6}) EXPECT_EQ(hits[i].state, HitState::kInvalid) << i;
  EXPECT_EQ(hits[3].t, 0x1p+249);
  EXPECT_EQ(hits[4].t, 2);
  EXPECT_EQ(hits[5].t, 1);
}

/// Floats know nothing of these points: they visit all of a tree, and no more.
TEST(Points, BeyondFloatsEqualTheOracle) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::icosphere(3)), {})}));
  const auto snapshot = scene.snapshot();
  ASSERT_TRUE(query::build_all(*snapshot, nullptr, nullptr));
  const std::vector<Vec3d> at{{0x1p+61, 0, 0},
                              {0, -0x1p+90, 3},
                              {0x1p+200, 0x1p+199, 0},
                              {0, 0, 0x1p+59},
                              {0x1p+40, 0x1p+40, 1}};
  expect_nearest(*snapshot, BruteNearest(snapshot), at, options_of_points());
}

TEST(Points, HaveTheWeightsOfTheNearestPoint) {
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::single_triangle()), {})}));
  const std::vector<Vec3d> at{{0.25, 0.5, 3}, {-1, -1, 0}, {0.5, -2, 1}, {2, 2, 0}};
  std::vector<Hit> hits(at.size());
  ASSERT_TRUE(trace(*scene.snapshot(), points_of(at), hits, options_of_points()));
  const std::vector<std::pair<float, float>> weights{
      {0.25f, 0.5f}, {0, 0}, {0.5f, 0}, {0.5f, 0.5f}};
  for (std::size_t i = 0; i < at.size(); ++i) {
    EXPECT_EQ(std::pair(hits[i].u, hits[i].v), weights[i]) << i;
    EXPECT_EQ(std::fabs(hits[i].normal.z), 1) << i;
  }
}

}  // namespace
}  // namespace sightline::scenegraph
