// Sides of points by normals: every state of the trees gives the answers of formulas, of solid
// angles, and of the definition in 113 bits.
#include "scenegraph/query/normal_sides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_nearest.h"
#include "tests/support/brute_sides.h"
#include "tests/support/hard_points.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Face;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using model::Affine;
using tests::TestMesh;

using SharedSnapshot = std::shared_ptr<const revision::Snapshot>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kGrowths = {Growth::kNone, Growth::kFirstTouch, Growth::kDemand,
                                 Growth::kFull};

std::vector<Ray> points_of(std::span<const Vec3d> at,
                           std::uint32_t mask = accel::geometry::kAllMasks) {
  std::vector<Ray> points;
  points.reserve(at.size());
  for (const Vec3d& p : at)
    points.push_back({.origin = p, .direction = {1, 0, 0}, .tmax = 0, .mask = mask});
  return points;
}

TraceOptions options_of(Growth growth) {
  TraceOptions options;
  options.growth = growth;
  return options;
}

Result<TraceStats> find_by_normal(const revision::Snapshot& snapshot,
                                  const accel::geometry::RayColumns& points, std::span<Side> sides,
                                  const TraceOptions& options) {
  return find_sides(snapshot, points, {.rule = SideRule::kNormal}, {sides, {}}, options);
}

std::vector<Side> sides_of(const SharedSnapshot& snapshot, std::span<const Ray> points,
                           const TraceOptions& options) {
  std::vector<Side> sides(points.size(), Side::kInvalid);
  const auto found = find_by_normal(*snapshot, accel::geometry::columns_of(points), sides, options);
  EXPECT_TRUE(found && found->rays == points.size());
  return sides;
}

SharedSnapshot only_mesh(const TestMesh& mesh, const Affine& frame = {}) {
  return tests::snapshot_of({tests::put_node(-1, 0, tests::mesh_of(mesh), frame)});
}

using IsInside = std::function<bool(const Vec3d&)>;

/// Compares the sides of points of a new scene in every state of its trees.
void expect_sides(const TestMesh& mesh, const Affine& frame, std::span<const Vec3d> at,
                  const std::vector<bool>& inside) {
  const std::vector<Ray> points = points_of(at);
  for (const Growth growth : kGrowths) {
    const std::vector<Side> sides = sides_of(only_mesh(mesh, frame), points, options_of(growth));
    for (std::size_t i = 0; i < at.size(); ++i) {
      ASSERT_EQ(sides[i], inside[i] ? Side::kInside : Side::kOutside)
          << i << ": (" << at[i].x << ", " << at[i].y << ", " << at[i].z << ")";
    }
  }
}

void expect_sides(const TestMesh& mesh, std::span<const Vec3d> at, const IsInside& is_inside) {
  std::vector<bool> inside;
  for (const Vec3d& p : at) inside.push_back(is_inside(p));
  expect_sides(mesh, {}, at, inside);
}

/// The solid angle of the surface as seen from p, as a share of the sphere: 1 inside, 0 outside of
/// a closed mesh (van Oosterom, Strackee 1983).
long double winding_of(const TestMesh& mesh, const Vec3d& p) {
  using Vec = accel::geometry::Vec3<long double>;
  long double sum = 0;
  for (const Face& face : mesh.faces) {
    std::array<Vec, 3> r;
    std::array<long double, 3> size{};
    for (std::size_t i = 0; i < 3; ++i) {
      r[i] = Vec(mesh.vertices[face[i]]) - Vec(p);
      size[i] = length(r[i]);
    }
    const long double whole = size[0] * size[1] * size[2] + dot(r[0], r[1]) * size[2] +
                              dot(r[1], r[2]) * size[0] + dot(r[2], r[0]) * size[1];
    sum += std::atan2(dot(r[0], cross(r[1], r[2])), whole);
  }
  return sum / (2 * std::acos(-1.0L));
}

/// Points around each corner and edge and beside each face of a mesh, at distances from an ulp to
/// its size.
std::vector<Vec3d> points_around(const TestMesh& mesh, std::size_t count, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Face& face = mesh.faces[random.below(mesh.faces.size())];
    std::array<double, 3> weights{1, 0, 0};
    if (i % 3 > 0) weights[1] = random.uniform();
    if (i % 3 > 1) weights[2] = random.uniform();
    const double sum = weights[0] + weights[1] + weights[2];
    Vec3d at;
    for (std::size_t k = 0; k < 3; ++k)
      at = at + Vec3d(mesh.vertices[face[k]]) * (weights[k] / sum);
    points.push_back(at + random.direction() * std::exp2(random.uniform(-45, 1)));
  }
  return points;
}

/// A sphere with mountains: closed, and it does not meet itself.
TestMesh bumpy_sphere(int level, double height, std::uint64_t seed) {
  tests::Random random(seed);
  TestMesh mesh = tests::icosphere(level);
  for (Vec3f& v : mesh.vertices) v = Vec3f(Vec3d(v) * (1 + height * random.uniform()));
  return mesh;
}

/// A tetrahedron with corners in any order, facing outward.
TestMesh tetrahedron(const std::array<Vec3f, 4>& corners) {
  TestMesh mesh;
  mesh.vertices.assign(corners.begin(), corners.end());
  const Vec3d a(corners[0]), b(corners[1]), c(corners[2]), d(corners[3]);
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  if (dot(cross(b - a, c - a), d - a) < 0) {
    for (Face& face : mesh.faces) std::swap(face[1], face[2]);
  }
  return mesh;
}

/// `sides` faces from (0, 0, 0) down to a circle at z = -height, and the disk that closes it.
TestMesh cone(std::uint32_t sides, float height) {
  TestMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, -height}};
  for (const auto& [x, y] : tests::unit_circle(sides))
    mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), -height});
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t here = 2 + i, next = 2 + (i + 1) % sides;
    mesh.faces.push_back({0, here, next});
    mesh.faces.push_back({1, next, here});
  }
  return mesh;
}

TEST(NormalSides, OfABoxAreThoseOfItsPlanesToAnUlp) {
  const Vec3f lo{-0.3f, 1, -7}, hi{0.2f, 1.7f, 3};
  std::array<std::vector<double>, 3> axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = static_cast<double>(lo[axis]), high = static_cast<double>(hi[axis]);
    axes[axis] = {low - 1, high + 2, 0.5 * (low + high), 0.9 * low + 0.1 * high};
    for (const double border : {low, high}) {
      for (const double beside : {-kInfinity, border, kInfinity})
        axes[axis].push_back(std::nextafter(border, beside));
    }
  }
  std::vector<Vec3d> at;
  for (const double x : axes[0]) {
    for (const double y : axes[1]) {
      for (const double z : axes[2]) at.push_back({x, y, z});
    }
  }
  const Vec3d low(lo), high(hi);
  expect_sides(tests::box(lo, hi), at, [&](const Vec3d& p) {
    return low.x < p.x && p.x < high.x && low.y < p.y && p.y < high.y && low.z < p.z &&
           p.z < high.z;
  });
}

TEST(NormalSides, OfClosedMeshesAreThoseOfSolidAngles) {
  for (const TestMesh& mesh : {tests::icosphere(2), bumpy_sphere(2, 0.4, 1),
                               bumpy_sphere(3, 0.1, 2), cone(16, 8), cone(64, 0.01f)}) {
    std::vector<Vec3d> at;
    std::vector<bool> inside;
    for (const Vec3d& p : points_around(mesh, 600, 3)) {
      const long double winding = winding_of(mesh, p);
      // Long doubles do not tell on which side of the next face a point is.
      if (std::fabs(winding - std::round(winding)) > 1e-4L) continue;
      at.push_back(p);
      inside.push_back(winding > 0.5L);
    }
    ASSERT_GT(at.size(), 500u);
    expect_sides(mesh, {}, at, inside);
  }
}

/// Beyond a sharp edge the nearest face's own normal may call a point inside.
TEST(NormalSides, OfSharpEdgesAreThoseOfAllFacesThatMeetThere) {
  const std::vector<TestMesh> meshes{
      // Edges of about 1, 0.01 and 1e-5 radians, and a needle.
      tetrahedron({Vec3f{-1, 0, 0}, {1, 0, 0}, {0, 1, 1}, {0, -0.2f, 1}}),
      tetrahedron({Vec3f{-1, 0, 0}, {1, 0, 0}, {0, 0.01f, 1}, {0, -0.01f, 1}}),
      tetrahedron({Vec3f{-1, 0, 0}, {1, 0, 0}, {0, 1e-5f, 1}, {0, -1e-5f, 1}}),
      tetrahedron({Vec3f{0, 0, 0}, {1e-3f, 0, 9}, {0, 1e-3f, 9}, {-1e-3f, -1e-3f, 9}}),
      tetrahedron({Vec3f{0.1f, 0.3f, 0.7f},
                   {0.9f, 0.4f, 0.2f},
                   {0.3f, 0.8f, 0.3f},
                   {0.31f, 0.79f, 0.29f}})};
  for (const TestMesh& mesh : meshes) {
    tests::Random random(5);
    std::vector<Vec3d> at;
    for (const Vec3d& p : points_around(mesh, 600, 6)) at.push_back(p);
    using Vec = accel::geometry::Vec3<long double>;
    const auto height = [&](const Face& face, const Vec3d& p) {
      const Vec a(mesh.vertices[face[0]]), b(mesh.vertices[face[1]]), c(mesh.vertices[face[2]]);
      const Vec normal = cross(b - a, c - a);
      return dot(normal, Vec(p) - a) / length(normal);
    };
    std::erase_if(at, [&](const Vec3d& p) {
      return std::ranges::any_of(
          mesh.faces, [&](const Face& face) { return std::fabs(height(face, p)) < 1e-17L; });
    });
    ASSERT_GT(at.size(), 500u);
    expect_sides(mesh, at, [&](const Vec3d& p) {
      return std::ranges::all_of(mesh.faces, [&](const Face& face) { return height(face, p) < 0; });
    });
  }
}

TEST(NormalSides, OfAnAcuteEdgeDoNotFollowTheLesserFace) {
  // The edge from (-1, 0, 0) to (1, 0, 0) is nearest; each of its two faces is behind one of them.
  const TestMesh mesh = tetrahedron({Vec3f{-1, 0, 0}, {1, 0, 0}, {0, 0.1f, -1}, {0, -0.1f, -1}});
  const std::vector<Vec3d> at{{0, 0, 0.5},      {0.1, 0.4, 0.1},   {0.1, -0.4, 0.1},
                              {0.1, 0.4, 0.01}, {0.1, -0.4, 0.01}, {0, 0, 0x1p-60},
                              {0, 0, -0.5}};
  expect_sides(mesh, at, [](const Vec3d& p) { return p.z < 0; });
}

TEST(NormalSides, OfInstancesAreThoseOfTheirMesh) {
  const TestMesh mesh = tests::box({-1, -2, -0.5f}, {1, 1, 3});
  const std::vector<Affine> frames{
      {{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7}},               // moved
      {{-1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7}},              // mirrored
      {{0.6, -0.8, 0, 1, 0.8, 0.6, 0, 2, 0, 0, 1, 3}},      // turned
      {{1, 0.7, 0.1, 0, -0.4, 2, 0.5, 0, 0.3, 0, 1, 9}},    // sheared
      {{0, 1, 0.3, 1e7, 1, 0, 0, -1e7, 0.1, 0, 0.5, 3e6}},  // mirrored and sheared, far away
      {{1000, 0, 0, 0, 0, 1e-3, 0, 0, 1, 0, 1, 0}}};
  for (const Affine& frame : frames) {
    tests::Random random(8);
    std::vector<Vec3d> at;
    std::vector<bool> inside;
    while (at.size() < 400) {
      const Vec3d q{random.uniform(-2, 2), random.uniform(-3, 2), random.uniform(-2, 4)};
      const double depth = std::min({q.x + 1, 1 - q.x, q.y + 2, 1 - q.y, q.z + 0.5, 3 - q.z});
      if (std::fabs(depth) < 1e-6) continue;
      at.push_back(frame.point(q));
      inside.push_back(depth > 0);
    }
    // A shear may turn a wide angle of a box into a sharp one, but the box stays convex and closed.
    expect_sides(mesh, frame, at, inside);
  }
}

TEST(NormalSides, OfTerrainAreAboveAndBelow) {
  tests::Random random(4);
  TestMesh mesh = tests::planar_sheet(16);
  for (Vec3f& v : mesh.vertices) v.z = static_cast<float>(0.3 * random.uniform());
  std::vector<Vec3d> at;
  for (int i = 0; i < 300; ++i) {
    // Where the edges of the sheet are not nearest.
    const double z = random.below(2) == 0 ? random.uniform(0.31, 3) : random.uniform(-3, -0.01);
    at.push_back({random.uniform(4, 12), random.uniform(4, 12), z});
  }
  expect_sides(mesh, at, [](const Vec3d& p) { return p.z < 0; });
}

TEST(NormalSides, WhereAThousandFacesMeet) {
  for (const double height : {4.0, 0.25, 0.001}) {
    const TestMesh mesh = cone(1024, static_cast<float>(height));
    std::vector<Vec3d> at;
    for (const double z : {2.0, 0.1, 1e-9, 0x1p-200}) {
      at.push_back({0, 0, z});
      at.push_back({0.01 * z * height, -0.02 * z * height, z});
      at.push_back({0, 0, -z * 0x1p-10 * height});
    }
    expect_sides(mesh, at, [](const Vec3d& p) { return p.z < 0; });
  }
}

TEST(NormalSides, OfTheCenterOfASphere) {
  const std::vector<Vec3d> at(100, Vec3d{});
  expect_sides(tests::icosphere(5), at, [](const Vec3d&) { return true; });
  TestMesh hollow = tests::icosphere(4);
  for (Face& face : hollow.faces) std::swap(face[1], face[2]);
  expect_sides(hollow, at, [](const Vec3d&) { return false; });
}

TEST(NormalSides, DoNotDependOnFacesWithoutArea) {
  TestMesh mesh = tests::cube();
  const std::vector<Face> faces = std::exchange(mesh.faces, {});
  for (std::uint32_t i = 0; i < 8; ++i) {
    mesh.faces.push_back({i, i, i});
    mesh.faces.push_back({faces[i][0], faces[i][1], faces[i][0]});
  }
  mesh.faces.insert(mesh.faces.end(), faces.begin(), faces.end());
  const std::vector<Vec3d> at{{1.5, 1.5, 1.5}, {-1.25, -1.5, -1.5}, {1.5, 1.5, 0.25},
                              {1.5, 0, 0},     {0.5, 0, 0},         {0.99, 0.99, 0.99},
                              {0, -3, -3},     {0x1p-300, 0, -0.5}, {1, 1, 1}};
  expect_sides(mesh, at, [](const Vec3d& p) {
    return std::fabs(p.x) < 1 && std::fabs(p.z) < 1 && std::fabs(p.y) < 1;
  });
  mesh.faces.resize(16);
  expect_sides(mesh, at, [](const Vec3d&) { return false; });
}

TEST(NormalSides, OfFacesOfBothWindingsAreOutside) {
  TestMesh mesh = tests::single_triangle();
  mesh.faces.push_back({mesh.faces[0][0], mesh.faces[0][2], mesh.faces[0][1]});
  const std::vector<Vec3d> beside{{-1, -1, 2}, {-1, -1, -2}, {0.25, -1, 0.7}, {2, 2, 1e-9}};
  expect_sides(mesh, beside, [](const Vec3d&) { return false; });
  // Inside, the lesser face decides.
  const std::vector<Vec3d> above{{0.25, 0.25, 1}, {0.25, 0.25, -1}, {0.25, 0.25, 0}};
  expect_sides(mesh, above, [](const Vec3d& p) { return p.z < 0; });
}

TEST(NormalSides, InThePlaneOfAnOpenSurfaceAreOutside) {
  const std::vector<Vec3d> at{{-1, 2, 0}, {5, 5, 0}, {2, -0.1, 0}, {-1, -1, -1}, {-1, -1, 1}};
  expect_sides(tests::planar_sheet(4), at, [](const Vec3d& p) { return p.z < 0; });
}

TEST(NormalSides, SeeTheNodesThatTheirQueryAndMaskSelect) {
  const auto put = [](model::NodeRef node, float size, std::uint32_t mask) {
    auto box = tests::put_node(node, 0, tests::mesh_of(tests::cube(-size, size)));
    box.mask = mask;
    return box;
  };
  const SharedSnapshot snapshot = tests::snapshot_of({put(-1, 1, 1), put(-2, 3, 2)});
  const std::vector<Vec3d> at{{2, 0, 0}, {1.5, 1.5, 1.5}, {0.5, 0, 0}, {4, 4, 4}};
  const auto inside = [&](std::uint32_t mask, const TraceOptions& options) {
    std::vector<bool> answers;
    for (const Side side : sides_of(snapshot, points_of(at, mask), options))
      answers.push_back(side == Side::kInside);
    return answers;
  };
  for (const Growth growth : kGrowths) {
    TraceOptions options = options_of(growth);
    // The first point is as near to the inner box, whose node is less.
    EXPECT_EQ(inside(3, options), (std::vector{false, false, true, false}));
    EXPECT_EQ(inside(1, options), (std::vector{false, false, true, false}));
    EXPECT_EQ(inside(2, options), (std::vector{true, true, true, false}));
    EXPECT_EQ(inside(0, options), (std::vector{false, false, false, false}));
    const std::vector<model::NodeId> inner{1};
    const auto outer = Selection::make(snapshot, 0, inner);
    ASSERT_TRUE(outer);
    options.selection = &*outer;
    EXPECT_EQ(inside(3, options), (std::vector{true, true, true, false}));
  }
}

TEST(NormalSides, OfInvalidPointsAreMarked) {
  std::vector<Ray> points = points_of(std::vector<Vec3d>{
      {kNan, 0, 0}, {0, kInfinity, 0}, {0, 0, 0x1p+251}, {0, 0, 0}, {0, 0, 0x1p+249}, {0, 0, 0}});
  points.back().tmax = kNan;
  std::vector<Side> sides(points.size());
  const auto found = find_by_normal(*only_mesh(tests::cube()), accel::geometry::columns_of(points),
                                    sides, options_of(Growth::kFirstTouch));
  ASSERT_TRUE(found);
  EXPECT_EQ(sides, (std::vector{Side::kInvalid, Side::kInvalid, Side::kInvalid, Side::kInside,
                                Side::kOutside, Side::kInvalid}));
  EXPECT_EQ(found->rays, 6u);
  EXPECT_EQ(found->invalid, 4u);
  EXPECT_EQ(found->unanswered, 0u);
  EXPECT_EQ(found->hits + found->hits_found + found->cut_off, 0u);
  EXPECT_GT(found->triangle_tests, 0u);
}

TEST(NormalSides, OfAnEmptySceneAreOutside) {
  const std::vector<Vec3d> at(3, Vec3d{});
  const std::vector<Side> sides =
      sides_of(Scene().snapshot(), points_of(at), options_of(Growth::kFirstTouch));
  EXPECT_EQ(sides, std::vector<Side>(3, Side::kOutside));
  EXPECT_TRUE(sides_of(Scene().snapshot(), {}, options_of(Growth::kFirstTouch)).empty());
}

TEST(NormalSides, AreUnansweredOnceCancelled) {
  const SharedSnapshot snapshot = only_mesh(tests::icosphere(3));
  const std::vector<Ray> points = points_of(std::vector<Vec3d>(1'000, Vec3d{0.5, 0, 0}));
  const std::atomic<bool> stopped{true};
  for (const Growth growth : kGrowths) {
    TraceOptions options = options_of(growth);
    options.cancelled = &stopped;
    std::vector<Side> sides(points.size(), Side::kInside);
    const auto columns = accel::geometry::columns_of(points);
    const auto failed = find_by_normal(*snapshot, columns, sides, options);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, Code::kCancelled);
    options.partial = true;
    const auto found = find_by_normal(*snapshot, columns, sides, options);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->rays, 0u);
    EXPECT_EQ(found->unanswered, points.size());
    EXPECT_EQ(sides, std::vector<Side>(points.size(), Side::kUnanswered));
  }
}

TEST(NormalSides, AreRightOrUnansweredWhereTimeEnds) {
  const TestMesh mesh = bumpy_sphere(4, 0.2, 7);
  const std::vector<Ray> points = points_of(points_around(mesh, 4'000, 8));
  const auto columns = accel::geometry::columns_of(points);
  const std::vector<Side> expected =
      sides_of(only_mesh(mesh), points, options_of(Growth::kFirstTouch));
  for (int pause = 0; pause < 12; ++pause) {
    const SharedSnapshot snapshot = only_mesh(mesh);
    std::atomic<bool> stopped{false};
    std::thread stopping([&] {
      for (int i = 0; i < pause * 200; ++i) std::this_thread::yield();
      stopped = true;
    });
    TraceOptions options = options_of(Growth::kFirstTouch);
    options.cancelled = &stopped;
    options.partial = true;
    std::vector<Side> sides(points.size());
    const auto found = find_by_normal(*snapshot, columns, sides, options);
    stopping.join();
    ASSERT_TRUE(found);
    std::size_t marked = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      if (sides[i] == Side::kUnanswered) {
        ++marked;
      } else {
        ASSERT_EQ(sides[i], expected[i]) << i;
      }
    }
    EXPECT_EQ(found->unanswered, marked);
    EXPECT_EQ(found->rays, sides.size() - marked);
  }
}

class NormalSidesInFrames : public testing::TestWithParam<tests::Frames> {};

TEST_P(NormalSidesInFrames, EqualTheDefinition) {
  const auto updates = tests::random_hierarchy(30, GetParam(), 3);
  const SharedSnapshot first = tests::snapshot_of(updates);
  const std::vector<Vec3d> at = tests::hard_points(*first, 11, tests::rounds(600));
  const auto nearest = tests::BruteNearest(first).closest(at, kInfinity);
  const std::vector<tests::PlacedMesh> placed = tests::placed_meshes(*first);
  std::vector<std::vector<Side>> answers;
  for (const Growth growth : kGrowths)
    answers.push_back(sides_of(tests::snapshot_of(updates), points_of(at), options_of(growth)));
  std::size_t compared = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (const auto& sides : answers) ASSERT_EQ(sides[i], answers[0][i]) << i;
    ASSERT_TRUE(nearest[i]);
    const auto node = std::ranges::find(placed, nearest[i]->node, &tests::PlacedMesh::node);
    if (nearest[i]->distance == 0) {
      EXPECT_EQ(answers[0][i], Side::kOutside) << i;
      continue;
    }
    const auto behind = tests::is_behind(*node, nearest[i]->primitive, at[i]);
    if (!behind) continue;
    ++compared;
    EXPECT_EQ(answers[0][i], *behind ? Side::kInside : Side::kOutside)
        << i << ": (" << at[i].x << ", " << at[i].y << ", " << at[i].z << ") is "
        << nearest[i]->distance << " from " << nearest[i]->node << ", " << nearest[i]->primitive;
  }
  EXPECT_GT(compared, at.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(AllFrames, NormalSidesInFrames,
                         testing::Values(tests::Frames::kRigid, tests::Frames::kSheared,
                                         tests::Frames::kFar, tests::Frames::kFlat));

}  // namespace
}  // namespace sightline::scenegraph::query
