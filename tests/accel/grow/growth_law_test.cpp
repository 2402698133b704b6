// Growth of the builders' touches with the size of the scene: Wald, Havran 2006, section 4.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::grow {
namespace {

/// A square of n x n quads over hills of a few sizes: 2 n^2 triangles.
tests::TestMesh terrain(std::uint32_t n) {
  tests::TestMesh mesh = tests::planar_sheet(n);
  tests::Random random(1);
  for (geometry::Vec3f& v : mesh.vertices) {
    const double x = static_cast<double>(v.x) / n, y = static_cast<double>(v.y) / n;
    double z = 0;
    for (const double f : {3.0, 7.0, 17.0})
      z += std::sin(f * x + 2 * f * y) * std::cos(f * y - x) / f;
    // Jitter, as measured terrain has: a lattice would consist of ties.
    v = {static_cast<float>(x + 0.3 / n * random.uniform()),
         static_cast<float>(y + 0.3 / n * random.uniform()), static_cast<float>(z / 4)};
  }
  return mesh;
}

double touches(const tests::TestMesh& mesh, const published::AnyBuilder& builder) {
  mesh::MeshTree tree(mesh.view(), mesh::compute_mesh_stats(mesh.view()), builder,
                      mesh::References::kSoup);
  kdtree::BuildCounters counters;
  tree.expand_all(counters);
  return static_cast<double>(counters.touches);
}

struct Point {
  double n = 0, touches = 0;
};

std::vector<Point> measure_growth_of(const std::string_view builder,
                                     const std::vector<std::uint32_t>& sides) {
  std::vector<Point> points;
  for (const std::uint32_t side : sides) {
    const tests::TestMesh mesh = terrain(side);
    published::AnyBuilder values = *published::make_builder(builder);
    // The exact search of short lists costs every triangle the same, in steps as lists halve: a
    // short limit keeps the law visible at sizes that a test can build.
    std::visit(
        [](auto& kd) {
          if constexpr (requires { kd.exact_below; }) kd.exact_below = 36;
        },
        std::get<published::KdBuilder>(values));
    points.push_back({static_cast<double>(mesh.faces.size()), touches(mesh, values)});
  }
  return points;
}

/// Fits touches / n = a + b law(n) by least squares, and returns the largest relative deviation of
/// a point. `a` is the cost a triangle of the bottom of the tree, for any size of scene.
struct Fit {
  double a = 0, b = 0, residual = 0;
};

Fit fit(const std::vector<Point>& points, const std::function<double(double)>& law) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const auto size = static_cast<double>(points.size());
  for (const Point& p : points) {
    x += law(p.n) / size;
    y += p.touches / p.n / size;
    xx += law(p.n) * law(p.n) / size;
    xy += law(p.n) * p.touches / p.n / size;
  }
  Fit fit;
  fit.b = (xy - x * y) / (xx - x * x);
  fit.a = y - fit.b * x;
  for (const Point& p : points) {
    fit.residual = std::max(
        fit.residual, std::fabs(fit.a + fit.b * law(p.n) - p.touches / p.n) * p.n / p.touches);
  }
  return fit;
}

double log_n(double n) { return std::log2(n); }
double log2_n(double n) { return std::log2(n) * std::log2(n); }
double n_itself(double n) { return n; }

const std::vector<std::uint32_t> kSides{16, 32, 64, 128};  // 512 to 32,768 triangles

TEST(GrowthLaw, SweepMinMaxAndScanAreNLogN) {
  for (const std::string_view name : {"sah-sweep", "min-max-bins", "scan-all-axes"}) {
    const std::vector<Point> points = measure_growth_of(name, kSides);
    const Fit law = fit(points, log_n);
    EXPECT_LT(law.residual, 0.05) << name;
    EXPECT_GT(law.b, 0) << name;
    // Not faster either: from one size to the next the touches a triangle rise by less and less.
    const auto rise = [&](std::size_t i) {
      return points[i + 1].touches / points[i + 1].n - points[i].touches / points[i].n;
    };
    EXPECT_LT(rise(2), 1.1 * rise(0)) << name;
  }
}

TEST(GrowthLaw, SortIsNLog2N) {
  const std::vector<Point> sort = measure_growth_of("sah-sort", kSides),
                           sweep = measure_growth_of("sah-sweep", kSides);
  const Fit law = fit(sort, log2_n);
  EXPECT_LT(law.residual, 0.05);
  EXPECT_GT(law.b, 0);
  // One logarithm more than the sweep: their ratio rises with every size.
  for (std::size_t i = 0; i + 1 < sort.size(); ++i) {
    EXPECT_GT(sort[i + 1].touches / sweep[i + 1].touches,
              1.04 * sort[i].touches / sweep[i].touches);
  }
}

TEST(GrowthLaw, NaiveIsNSquared) {
  const Fit law = fit(measure_growth_of("sah-naive", {8, 16, 24, 32}), n_itself);
  EXPECT_LT(law.residual, 0.1);
  EXPECT_GT(law.b,
            6);  // At the root alone, two bounds on three axes are tried against every triangle
}

}  // namespace
}  // namespace sightline::accel::grow
