// Sides of points: every state of the trees, target and batch says what exact arithmetic says of
// closed meshes, also from their planes, edges and corners.
#include "scenegraph/sides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/local_ray.h"
#include "scenegraph/query/build.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "tests/accel/simd_targets.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/random.h"
#include "tests/support/rational.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using tests::TestMesh;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::shared_ptr<const revision::Snapshot> snapshot_of(std::span<const TestMesh> meshes) {
  Scene scene;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    EXPECT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(meshes[i]), {})}));
  return scene.snapshot();
}
std::shared_ptr<const revision::Snapshot> snapshot_of(const TestMesh& mesh) {
  return snapshot_of(std::span(&mesh, 1));
}

std::vector<Ray> points_of(std::span<const Vec3d> at) {
  std::vector<Ray> points;
  for (const Vec3d& p : at) points.push_back({.origin = p, .direction = {1, 0, 0}});
  return points;
}

struct Found {
  std::vector<Side> sides;
  std::vector<std::uint8_t> votes;
  TraceStats stats;
};

Found find(const revision::Snapshot& snapshot, std::span<const Ray> points,
           const SideQuestion& question = {}, const TraceOptions& options = {}) {
  Found found{std::vector<Side>(points.size()), std::vector<std::uint8_t>(points.size()), {}};
  const auto stats = find_sides(snapshot, accel::geometry::columns_of(points), question,
                                {found.sides, found.votes}, options);
  EXPECT_TRUE(stats);
  if (stats) found.stats = *stats;
  return found;
}

/// Whether o + (e, e^2, e^3) is in a closed mesh, for an e that is smaller than all differences of
/// its floats. It counts the faces that a ray from there crosses, in exact arithmetic.
bool is_inside(const TestMesh& mesh, const Vec3d& o) {
  const auto e = [](int power) { return tests::Dyadic(std::ldexp(1.0, -300 * power)); };
  const auto read = [](double x) {
    return tests::Dyadic(std::fabs(x) < accel::geometry::kSmallestRay ? 0 : x);
  };
  const tests::DyadicVec from = {read(o.x) + e(1), read(o.y) + e(2), read(o.z) + e(3)};
  const tests::DyadicVec along = tests::exactly(Vec3d{0.29, -0.83, 0.47});
  int crossed = 0;
  for (const auto& face : mesh.faces) {
    std::array<tests::DyadicVec, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = tests::exactly(mesh.vertices[face[i]]) - from;
    const auto side = [&](std::size_t i, std::size_t j) {
      return tests::dot(along, tests::cross(corner[i], corner[j])).sign();
    };
    const int first = side(0, 1);
    if (first == 0 || side(1, 2) != first || side(2, 0) != first) continue;
    const tests::DyadicVec normal = tests::cross(corner[1] - corner[0], corner[2] - corner[0]);
    crossed += tests::dot(normal, corner[0]).sign() == tests::dot(normal, along).sign() ? 1 : 0;
  }
  return crossed % 2 == 1;
}

/// Corners, middles of edges and faces, and points a unit in the last position beside them, mixed
/// with others.
std::vector<Vec3d> points_at(const TestMesh& mesh, std::size_t count, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<Vec3d> at;
  while (at.size() < count) {
    const auto& face = mesh.faces[random.below(mesh.faces.size())];
    const Vec3d a(mesh.vertices[face[0]]), b(mesh.vertices[face[1]]), c(mesh.vertices[face[2]]);
    const std::array<Vec3d, 4> kinds{a, (a + b) * 0.5, (a + b + c) * (1.0 / 3),
                                     random.direction() * 2.0 * random.uniform()};
    Vec3d p = kinds[random.below(4)];
    at.push_back(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (random.below(2) == 0) continue;
      p[axis] = std::nextafter(p[axis], random.below(2) == 0 ? -9.0 : 9.0);
    }
    at.push_back(p);
  }
  return at;
}

/// Points, and the sides that exact arithmetic gives them.
struct ExactSides {
  std::vector<Vec3d> at;
  std::vector<Side> sides;

  ExactSides(const TestMesh& mesh, std::size_t count, std::uint64_t seed)
      : at(points_at(mesh, count, seed)) {
    for (const Vec3d& p : at) sides.push_back(is_inside(mesh, p) ? Side::kInside : Side::kOutside);
  }
};

void expect_exact(const revision::Snapshot& snapshot, const ExactSides& expected,
                  const SideQuestion& question = {}, const TraceOptions& options = {}) {
  const Found found = find(snapshot, points_of(expected.at), question, options);
  for (std::size_t i = 0; i < expected.at.size(); ++i) {
    const Vec3d& p = expected.at[i];
    ASSERT_EQ(found.sides[i], expected.sides[i])
        << i << ": (" << p.x << ", " << p.y << ", " << p.z << ")";
    ASSERT_EQ(found.votes[i], found.sides[i] == Side::kInside ? question.rays : 0) << i;
  }
}

/// A ring of `parts` times `parts` quadrilaterals around the z axis.
TestMesh torus(std::uint32_t parts) {
  constexpr double kTurn = 6.283185307179586;
  TestMesh mesh;
  for (std::uint32_t i = 0; i < parts; ++i) {
    for (std::uint32_t j = 0; j < parts; ++j) {
      const double u = kTurn * i / parts, v = kTurn * j / parts, r = 1 + 0.4 * std::cos(v);
      mesh.vertices.push_back(Vec3f(Vec3d{r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)}));
      const std::uint32_t i1 = (i + 1) % parts, j1 = (j + 1) % parts;
      mesh.faces.push_back({i * parts + j, i1 * parts + j, i1 * parts + j1});
      mesh.faces.push_back({i * parts + j, i1 * parts + j1, i * parts + j1});
    }
  }
  return mesh;
}

TEST(Sides, AreExactInEveryStateOfTheTrees) {
  const TestMesh mesh = torus(12);
  const ExactSides expected(mesh, 400, 1);
  for (const SideRule rule : {SideRule::kParity, SideRule::kWinding}) {
    for (const Growth growth :
         {Growth::kNone, Growth::kFirstTouch, Growth::kDemand, Growth::kFull}) {
      TraceOptions options;
      options.growth = growth;
      expect_exact(*snapshot_of(mesh), expected, {.rule = rule}, options);
    }
    expect_exact(*snapshot_of(mesh), expected, {.rule = rule, .rays = 7});
  }
}

TEST(Sides, AreThoseOfAPointAlone) {
  const TestMesh mesh = torus(12);
  const auto snapshot = snapshot_of(mesh);
  const ExactSides expected(mesh, 100, 2);
  for (std::size_t i = 0; i < expected.at.size(); ++i) {
    const Found found = find(*snapshot, points_of(std::span(&expected.at[i], 1)));
    EXPECT_EQ(found.sides[0], expected.sides[i]) << i;
  }
}

/// Directions do not matter for closed meshes: all votes agree.
TEST(Sides, AgreeInAllDirections) {
  const TestMesh mesh = tests::icosphere(1);
  expect_exact(*snapshot_of(mesh), ExactSides(mesh, 100, 3), {.rays = kMaxSideRays});
}

/// A point that is moved by (e, e^2, e^3) decides, so boxes contain their lower faces.
TEST(Sides, HaveOneBoxForEachPointOfAGrid) {
  std::vector<TestMesh> boxes;
  for (int i = 0; i < 8; ++i) {
    const Vec3f lo{static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                   static_cast<float>(i >> 2)};
    boxes.push_back(tests::box(lo, lo + Vec3f{1, 1, 1}));
  }
  std::vector<Vec3d> at;
  for (int i = 0; i < 125; ++i) at.push_back({i % 5 * 0.5, i / 5 % 5 * 0.5, i / 25 * 0.5});
  std::vector<int> owners(at.size());
  for (const TestMesh& box : boxes) {
    const Found found = find(*snapshot_of(box), points_of(at));
    const Vec3d lo(box.vertices[0]);
    for (std::size_t i = 0; i < at.size(); ++i) {
      bool within = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        within &= at[i][axis] >= lo[axis] && at[i][axis] < lo[axis] + 1;
      EXPECT_EQ(found.sides[i] == Side::kInside, within) << i;
      owners[i] += found.sides[i] == Side::kInside ? 1 : 0;
    }
  }
  const Found all = find(*snapshot_of(boxes), points_of(at));
  for (std::size_t i = 0; i < at.size(); ++i)
    EXPECT_EQ(all.sides[i] == Side::kInside ? 1 : 0, owners[i]) << i;
}

TEST(Sides, OfPartsThatOverlapAreParityOrWinding) {
  const std::vector<TestMesh> boxes{tests::box({0, 0, 0}, {2, 2, 2}),
                                    tests::box({1, 1, 1}, {3, 3, 3})};
  const std::vector<Vec3d> at{{0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}, {2.5, 2.5, 2.5}, {0.5, 0.5, 2.5}};
  const auto snapshot = snapshot_of(boxes);
  const std::vector<Side> parity{Side::kInside, Side::kOutside, Side::kInside, Side::kOutside};
  const std::vector<Side> winding{Side::kInside, Side::kInside, Side::kInside, Side::kOutside};
  EXPECT_EQ(find(*snapshot, points_of(at)).sides, parity);
  EXPECT_EQ(find(*snapshot, points_of(at), {.rule = SideRule::kWinding}).sides, winding);
}

/// Rays from within cross faces from behind.
TEST(Sides, AreWhatCrossingsSay) {
  const std::vector<TestMesh> boxes{tests::box({0, 0, 0}, {2, 2, 2}),
                                    tests::box({1, 1, 1}, {3, 3, 3})};
  const std::vector<Ray> points =
      points_of(std::vector<Vec3d>{{1.5, 1.5, 1.5}, {kNan, 0, 0}, {1.5, 1.5, 50}, {2.5, 2.5, 2.5}});
  const auto snapshot = snapshot_of(boxes);
  constexpr std::uint32_t kRays = 5;
  std::vector<Side> sides(points.size());
  std::vector<std::uint32_t> crossings(points.size() * kRays);
  const auto crossed = [&](SideRule rule) {
    crossings.assign(crossings.size(), 99);
    EXPECT_TRUE(find_sides(*snapshot, accel::geometry::columns_of(std::span<const Ray>(points)),
                           {rule, kRays}, {.sides = sides, .crossings = crossings}, {}));
    return std::span<const std::uint32_t>(crossings);
  };
  const auto parity = crossed(SideRule::kParity);
  for (std::size_t i = 0; i < kRays; ++i) {
    EXPECT_EQ(parity[i], 2u);
    EXPECT_EQ(parity[kRays + i], 0u) << "invalid";
    EXPECT_EQ(parity[2 * kRays + i] % 2, 0u);
    EXPECT_EQ(parity[3 * kRays + i] % 2, 1u);
  }
  const auto winding = crossed(SideRule::kWinding);
  for (std::size_t i = 0; i < kRays; ++i) {
    EXPECT_EQ(static_cast<std::int32_t>(winding[i]), -2);
    EXPECT_EQ(winding[kRays + i], 0u) << "invalid";
    EXPECT_EQ(winding[2 * kRays + i], 0u);
    EXPECT_EQ(static_cast<std::int32_t>(winding[3 * kRays + i]), -1);
  }
}

TEST(Sides, AreRefusedForAnotherNumberOfCrossings) {
  const std::vector<Ray> points = points_of(std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}});
  std::vector<Side> sides(2);
  std::vector<std::uint32_t> crossings(7);
  for (const SideQuestion& question :
       {SideQuestion{SideRule::kParity, 3}, SideQuestion{SideRule::kNormal, 1}}) {
    const auto found = find_sides(*snapshot_of(tests::cube()),
                                  accel::geometry::columns_of(std::span<const Ray>(points)),
                                  question, {.sides = sides, .crossings = crossings}, {});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().reason, "COUNT_MISMATCH");
  }
}

/// A cube whose sides are nodes of their own, some with turned windings.
TEST(Sides, AreParitiesOverAllNodes) {
  TestMesh cube = tests::cube();
  std::vector<TestMesh> sides(cube.faces.size() / 2);
  for (std::size_t i = 0; i < cube.faces.size(); ++i) {
    auto face = cube.faces[i];
    if (i % 3 == 0) std::swap(face[0], face[1]);
    sides[i / 2].vertices = cube.vertices;
    sides[i / 2].faces.push_back(face);
  }
  const auto snapshot = snapshot_of(sides);
  expect_exact(*snapshot, ExactSides(cube, 400, 4));
}

/// A frame rounds points, so those that are very near the surface are left out.
TEST(Sides, AreThoseOfInstances) {
  tests::Random random(5);
  for (const tests::Frames frames : {tests::Frames::kRigid, tests::Frames::kSheared}) {
    const model::Affine frame = tests::random_frame(random, frames);
    Scene scene;
    ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(tests::cube()), frame)}));
    ASSERT_TRUE(query::build_all(*scene.snapshot(), nullptr, nullptr));
    std::vector<Vec3d> at;
    std::vector<Side> expected;
    for (int i = 0; i < 2'000; ++i) {
      const Vec3d local = random.direction() * 3.0 * random.uniform();
      const double most = std::max({std::fabs(local.x), std::fabs(local.y), std::fabs(local.z)});
      if (std::fabs(most - 1) < 1e-9) continue;
      at.push_back(frame.point(local));
      expected.push_back(most < 1 ? Side::kInside : Side::kOutside);
    }
    for (const SideRule rule : {SideRule::kParity, SideRule::kWinding})
      EXPECT_EQ(find(*scene.snapshot(), points_of(at), {.rule = rule, .rays = 3}).sides, expected);
  }
}

TEST(Sides, ShowHolesByVotes) {
  TestMesh open = tests::icosphere(2);
  open.faces.erase(open.faces.begin(), open.faces.begin() + 40);
  const std::vector<Vec3d> at{{0, 0, 0}};
  const Found found = find(*snapshot_of(open), points_of(at), {.rays = kMaxSideRays});
  EXPECT_EQ(found.sides[0], Side::kInside);
  EXPECT_GT(found.votes[0], kMaxSideRays / 2);
  EXPECT_LT(found.votes[0], kMaxSideRays);
}

TEST(Sides, SeeWhatTheMaskAndTheSelectionLeave) {
  const std::vector<TestMesh> boxes{tests::box({0, 0, 0}, {2, 2, 2}),
                                    tests::box({4, 4, 4}, {6, 6, 6})};
  const auto snapshot = snapshot_of(boxes);
  std::vector<Ray> points = points_of(std::vector<Vec3d>{{1, 1, 1}, {5, 5, 5}});
  const std::vector<model::NodeId> excluded{1};
  const auto selection = query::Selection::make(snapshot, 0, excluded);
  ASSERT_TRUE(selection);
  TraceOptions options;
  options.selection = &*selection;
  EXPECT_EQ(find(*snapshot, points, {}, options).sides,
            (std::vector<Side>{Side::kOutside, Side::kInside}));
  points[1].mask = 0;
  EXPECT_EQ(find(*snapshot, points).sides, (std::vector<Side>{Side::kInside, Side::kOutside}));
}

TEST(Sides, DoNotDependOnLimits) {
  std::vector<Ray> points = points_of(std::vector<Vec3d>{{0, 0, 0}, {0, 0, 0}, {0, 0, 5}});
  points[0].tmax = 0;
  points[1].tmax = -3;
  points[2].tmax = 1;
  EXPECT_EQ(find(*snapshot_of(tests::cube()), points).sides,
            (std::vector<Side>{Side::kInside, Side::kInside, Side::kOutside}));
}

TEST(Sides, OfBadPointsAreInvalid) {
  std::vector<Ray> points =
      points_of(std::vector<Vec3d>{{kNan, 0, 0}, {0, 0, 0x1p+251}, {0, 0, 0}, {0, 0, 0}});
  points[2].tmax = kNan;
  const Found found = find(*snapshot_of(tests::cube()), points, {.rays = 3});
  EXPECT_EQ(found.sides,
            (std::vector<Side>{Side::kInvalid, Side::kInvalid, Side::kInvalid, Side::kInside}));
  EXPECT_EQ(found.votes, (std::vector<std::uint8_t>{0, 0, 0, 3}));
  EXPECT_EQ(found.stats.rays, 4u);
  EXPECT_EQ(found.stats.invalid, 3u);
}

TEST(Sides, AreUnansweredWhereThereIsNoTime) {
  const std::atomic<bool> cancelled{true};
  TraceOptions options;
  options.cancelled = &cancelled;
  options.partial = true;
  const std::vector<Vec3d> at(3, Vec3d{0, 0, 0});
  const Found found = find(*snapshot_of(tests::cube()), points_of(at), {}, options);
  EXPECT_EQ(found.sides, std::vector<Side>(3, Side::kUnanswered));
  EXPECT_EQ(found.stats.unanswered, 3u);
}

TEST(Sides, AreRefusedForOtherNumbersOfRays) {
  const auto snapshot = snapshot_of(tests::cube());
  const std::vector<Ray> point = points_of(std::vector<Vec3d>{{0, 0, 0}});
  std::vector<Side> sides(1);
  for (const SideQuestion& question :
       {SideQuestion{.rays = 0}, SideQuestion{.rays = 2}, SideQuestion{.rays = 65},
        SideQuestion{.rule = SideRule::kNormal, .rays = 3}}) {
    const auto found =
        find_sides(*snapshot, accel::geometry::columns_of(point), question, {sides, {}}, {});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, Code::kInvalidArgument);
    EXPECT_EQ(found.error().reason, "SIDE_RAYS");
  }
}

class SidesOnTarget : public tests::OnSimdTarget {};

TEST_P(SidesOnTarget, AreExact) {
  for (const TestMesh& mesh : {torus(10), tests::icosphere(2), tests::cube()}) {
    const auto snapshot = snapshot_of(mesh);
    ASSERT_TRUE(query::build_all(*snapshot, nullptr, nullptr));
    const ExactSides expected(mesh, 100, 6);
    expect_exact(*snapshot, expected);
    expect_exact(*snapshot, expected, {.rule = SideRule::kWinding});
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, SidesOnTarget, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::scenegraph
