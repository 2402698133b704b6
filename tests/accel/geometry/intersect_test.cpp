// The hit rule: owners of edges, parity, exactness, t.
#include "accel/geometry/intersect.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::geometry {
namespace {

LocalRay ray(const Vec3d& origin, const Vec3d& direction) {
  return *make_local_ray(origin, direction);
}

std::vector<double> all_hits(const tests::TestMesh& mesh, const LocalRay& r) {
  std::vector<double> ts;
  for (const Face& f : mesh.faces) {
    if (const auto t =
            intersect(r, mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]])) {
      ts.push_back(*t * r.unit);
    }
  }
  return ts;
}

/// The rule in exact integers, for small integer rays and triangles.
struct Integers {
  __extension__ using I = __int128;
  using V = std::array<I, 3>;
  static V minus(const V& a, const V& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
  static V cross(const V& a, const V& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static I dot(const V& a, const V& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static int sign(I x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
  static int edge(const V& o, const V& d, const V& a, const V& b) {
    if (const int s = sign(dot(d, cross(minus(a, o), minus(b, o)))); s != 0) return s;
    for (const I g : cross(minus(a, b), d)) {
      if (g != 0) return sign(g);
    }
    return 0;
  }
  static bool hit(const V& o, const V& d, const V& a, const V& b, const V& c) {
    const int s = edge(o, d, a, b);
    return s != 0 && edge(o, d, b, c) == s && edge(o, d, c, a) == s;
  }
};

TEST(Intersect, AgreesWithExactIntegersOnDegenerateRays) {
  tests::Random random(11);
  const auto small = [&](std::uint64_t n) {
    return static_cast<int>(random.below(2 * n + 1)) - static_cast<int>(n);
  };
  int hits = 0;
  for (int round = 0; round < 300000; ++round) {
    int n[15];
    // Few distinct values: rays often meet edges, vertices and planes exactly.
    for (int& x : n) x = small(3);
    if (n[3] == 0 && n[4] == 0 && n[5] == 0) continue;
    const auto v = [&](int i) {
      return Vec3f{static_cast<float>(n[i]), static_cast<float>(n[i + 1]),
                   static_cast<float>(n[i + 2])};
    };
    const auto w = [&](int i) { return Integers::V{n[i], n[i + 1], n[i + 2]}; };
    const bool expected = Integers::hit(w(0), w(3), w(6), w(9), w(12));
    const auto t = intersect(ray(Vec3d(v(0)), Vec3d(v(3))), v(6), v(9), v(12));
    ASSERT_EQ(t.has_value(), expected) << "round " << round;
    hits += expected ? 1 : 0;
  }
  EXPECT_GT(hits, 1000);
}

TEST(Intersect, HitsLieAheadOrBehindExactly) {
  tests::Random random(14);
  int on_planes = 0;
  for (int round = 0; round < 200'000; ++round) {
    const auto v = [&] {
      return Integers::V{static_cast<int>(random.below(5)), static_cast<int>(random.below(5)),
                         static_cast<int>(random.below(5))};
    };
    const auto of = [](const Integers::V& w) {
      return Vec3f{static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])};
    };
    const Integers::V o = v(), a = v(), b = v(), c = v(), d = Integers::minus(v(), {2, 2, 2});
    if (d == Integers::V{}) continue;
    const LocalRay r = ray(Vec3d(of(o)), Vec3d(of(d)));
    const auto t = intersect(r, of(a), of(b), of(c));
    if (!t) continue;
    const Integers::V normal = Integers::cross(Integers::minus(b, a), Integers::minus(c, a));
    int height = Integers::sign(Integers::dot(normal, Integers::minus(a, o)));
    on_planes += height == 0 ? 1 : 0;
    for (std::size_t i = 0; height == 0; ++i) height = -Integers::sign(normal[i]);
    const bool ahead = height == Integers::sign(Integers::dot(normal, d));
    ASSERT_EQ(is_ahead(r, *t, of(a), of(b), of(c)), ahead) << "round " << round;
    ASSERT_EQ(is_ahead(r, *t, of(a), of(c), of(b)), ahead) << "round " << round;
  }
  EXPECT_GT(on_planes, 1000);
}

TEST(Intersect, WindingDoesNotMatter) {
  tests::Random random(12);
  for (int round = 0; round < 50000; ++round) {
    const auto p = [&] {
      return Vec3f{static_cast<float>(random.below(4)), static_cast<float>(random.below(4)),
                   static_cast<float>(random.below(4))};
    };
    const Vec3f a = p(), b = p(), c = p();
    const Vec3d d(static_cast<Vec3d>(p()) - Vec3d{1.5, 1.5, 2});
    const LocalRay r = ray({1, 1, 7}, d);
    const bool hit = intersect(r, a, b, c).has_value();
    ASSERT_EQ(intersect(r, b, c, a).has_value(), hit);
    ASSERT_EQ(intersect(r, c, b, a).has_value(), hit);
  }
}

TEST(Intersect, EveryPointOfASheetHasOneOwner) {
  const tests::TestMesh sheet = tests::planar_sheet(4);
  // Through vertices, edge midpoints and diagonals: straight down and slanted.
  for (const Vec3d d :
       {Vec3d{0, 0, -1}, Vec3d{0.5, 0.25, -1}, Vec3d{-0.0, 1, -2}, Vec3d{1, 0, -4}}) {
    for (int x = 1; x < 16; ++x) {
      for (int y = 1; y < 16; ++y) {
        const Vec3d target{x * 0.25, y * 0.25, 0};
        ASSERT_EQ(all_hits(sheet, ray(target - d * 8.0, d)).size(), 1u) << x << " " << y;
      }
    }
  }
}

TEST(Intersect, ClosedSurfacesAreCrossedAnEvenNumberOfTimesFromOutside) {
  const tests::TestMesh sphere = tests::icosphere(3);
  tests::Random random(13);
  for (std::size_t i = 0; i < sphere.vertices.size(); ++i) {
    const Vec3d v(sphere.vertices[i]);
    ASSERT_EQ(all_hits(sphere, ray({0, 0, 0}, v)).size() % 2, 0u);  // The line: both directions
    std::size_t ahead = 0;
    for (const double t : all_hits(sphere, ray({0, 0, 0}, v))) ahead += t > 0 ? 1 : 0;
    ASSERT_EQ(ahead, 1u) << "vertex " << i;
    const Vec3d from = random.direction() * 5.0;
    ASSERT_EQ(all_hits(sphere, ray(from, v - from)).size() % 2, 0u) << "vertex " << i;
  }
}

TEST(Intersect, EdgeOnAndEmptyTrianglesAreNeverHit) {
  const LocalRay r = ray({0, 0, 5}, {0, 0, -1});
  EXPECT_FALSE(
      intersect(r, {-1, 0, 0}, {1, 0, 0}, {0, 0, 3}));  // The ray lies in the triangle's plane
  EXPECT_FALSE(intersect(r, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(intersect(r, {-1, 0, 0}, {1, 0, 0}, {3, 0, 0}));
  EXPECT_FALSE(intersect(r, {-1, -1, 0}, {1, 1, 0}, {1, 1, 0}));
}

TEST(Intersect, TIsInUnitsOfTheDirectionsLength) {
  const Vec3f a{-1, -1, 2}, b{1, -1, 2}, c{0, 1, 2};
  for (const double scale : {1.0, 3.0, 1e-200, 1e200, 0.1}) {
    const LocalRay r = ray({0, 0, 0}, {0, 0, scale});
    const auto t = intersect(r, a, b, c);
    ASSERT_TRUE(t);
    EXPECT_DOUBLE_EQ(*t * r.unit, 2 / scale);
  }
  const LocalRay behind = ray({0, 0, 5}, {0, 0, 1});
  EXPECT_DOUBLE_EQ(*intersect(behind, a, b, c) * behind.unit, -3);
}

/// At grazing angles and on slivers t keeps its error bound, because it is then computed exactly.
TEST(Intersect, TKeepsItsErrorBoundWhereDoublesWouldNot) {
  tests::Random random(14);
  int checked = 0;
  for (int round = 0; round < 20000; ++round) {
    const auto near = [&](double x, double e) {
      return static_cast<float>(x + random.uniform(-e, e));
    };
    const double thin = std::pow(10.0, -random.uniform(0, 7));
    const Vec3f a{near(0, 1), near(0, 1), near(0, thin)}, b{near(3, 1), near(0, 1), near(0, thin)},
        c{near(1, 1), near(0, 1) + static_cast<float>(thin), near(0, thin)};
    const Vec3d inside = (Vec3d(a) * 0.3 + Vec3d(b) * 0.3 + Vec3d(c) * 0.4);
    const Vec3d o{random.uniform(-50, 50), random.uniform(-50, 50), thin * random.uniform(-50, 50)};
    const LocalRay r = ray(o, inside - o);
    const auto t = intersect(r, a, b, c);
    if (!t) continue;  // Rounding of `inside`
    ++checked;
    // The same in long double, which is accurate enough for these sizes.
    using L = long double;
    const auto ld = [](const Vec3d& v) { return std::array<L, 3>{v.x, v.y, v.z}; };
    const auto sub = [](const std::array<L, 3>& p, const std::array<L, 3>& q) {
      return std::array<L, 3>{p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    };
    const auto crs = [](const std::array<L, 3>& p, const std::array<L, 3>& q) {
      return std::array<L, 3>{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                              p[0] * q[1] - p[1] * q[0]};
    };
    const auto dt = [](const std::array<L, 3>& p, const std::array<L, 3>& q) {
      return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    };
    const auto n = crs(sub(ld(Vec3d(b)), ld(Vec3d(a))), sub(ld(Vec3d(c)), ld(Vec3d(a))));
    const L exact = dt(n, sub(ld(Vec3d(a)), ld(r.origin))) / dt(n, ld(r.direction));
    double distance = 0;
    for (const Vec3f& v : {a, b, c}) {
      const Vec3d p = Vec3d(v) - r.origin;
      distance = std::max({distance, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    }
    ASSERT_NEAR(*t, static_cast<double>(exact), distance * kHitError);
  }
  EXPECT_GT(checked, 10000);
}

TEST(Intersect, BarycentricsAreTheWeightsOfTheVertices) {
  const Vec3f a{0, 0, 0}, b{4, 0, 0}, c{0, 2, 0};
  const LocalRay r = ray({1, 0.5, 3}, {0, 0, -1});
  const auto t = intersect(r, a, b, c);
  ASSERT_TRUE(t);
  const Barycentric w = barycentric(r, *t, a, b, c);
  EXPECT_DOUBLE_EQ(w.u, 0.25);
  EXPECT_DOUBLE_EQ(w.v, 0.25);
}

TEST(MakeLocalRay, RefusesInvalidRays) {
  const double nan = std::nan(""), inf = kHitError / 0.0;
  EXPECT_FALSE(make_local_ray({0, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(make_local_ray({0, 0, 0}, {-0.0, 0, 0}));
  EXPECT_FALSE(make_local_ray({nan, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(make_local_ray({0, 0, 0}, {1, nan, 0}));
  EXPECT_FALSE(make_local_ray({0, inf, 0}, {1, 0, 0}));
  EXPECT_FALSE(make_local_ray({0, 0, 0}, {inf, 0, 0}));
  EXPECT_FALSE(make_local_ray({1e300, 0, 0}, {1, 0, 0}));
}

TEST(MakeLocalRay, ScalesByPowersOfTwo) {
  const auto r = make_local_ray({1, 2, 3}, {-12, 3, 1e-300});
  ASSERT_TRUE(r);
  EXPECT_EQ(r->direction, (Vec3d{-1.5, 0.375, 0}));
  EXPECT_EQ(r->unit, 0.125);
}

}  // namespace
}  // namespace sightline::accel::geometry
