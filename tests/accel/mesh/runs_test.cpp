// Runs of triangles: each triangle is in one run, boxes contain their triangles, and runs do not
// change hits.
#include "accel/mesh/runs.h"
#include "accel/published/any_builder.h"

#include <gtest/gtest.h>

#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/mesh_tree.h"
#include "tests/support/mesh_query.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

using tests::MeshQuery;
using tests::TestMesh;

/// A wavy sheet with faces in row order.
TestMesh waves(std::uint32_t side) {
  TestMesh mesh = tests::planar_sheet(side);
  for (geometry::Vec3f& v : mesh.vertices) {
    const double u = static_cast<double>(v.x) / 16, w = static_cast<double>(v.y) / 16;
    v = geometry::Vec3f(geometry::Vec3d{u, 0.3 * std::sin(3 * u) * std::cos(2 * w), w});
  }
  return mesh;
}

TestMesh shuffled(TestMesh mesh) {
  tests::Random random(1);
  for (std::size_t i = mesh.faces.size(); i > 1; --i)
    std::swap(mesh.faces[i - 1], mesh.faces[random.below(i)]);
  return mesh;
}

/// Counts the faces that runs open to, and checks that boxes contain them.
void visit(const geometry::MeshView& mesh, const kdtree::Reference& run, std::vector<int>& seen) {
  std::vector<kdtree::Reference> finer;
  kdtree::BuildCounters counters;
  open_run(mesh, run, finer, counters);
  const FaceRange faces = faces_of_run(mesh, run);
  ASSERT_EQ(counters.touches_prepare, faces.end - faces.begin);
  std::uint32_t weight = 0;
  for (const kdtree::Reference& ref : finer) {
    geometry::Aabb both = run.bounds();
    both.grow(ref.bounds());
    ASSERT_EQ(both, run.bounds());
    ASSERT_GT(ref.weight, 0u);
    weight += ref.weight;
    if (ref.openable()) {
      visit(mesh, ref, seen);
      continue;
    }
    ASSERT_TRUE(ref.id >= faces.begin && ref.id < faces.end);
    ASSERT_EQ(ref.bounds(), *face_bounds(mesh, ref.id));
    ++seen[ref.id];
  }
  ASSERT_EQ(weight, run.weight);
}

TEST(Runs, OpenToEveryFiniteTriangleOnce) {
  for (const std::uint32_t side : {3u, 64u, 100u, 257u}) {
    TestMesh mesh = waves(side);
    if (side > 10) {
      for (std::size_t i = 40; i < 75; ++i)
        mesh.faces[i] = {geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex};
      mesh.vertices[500].x = std::numeric_limits<float>::quiet_NaN();
    }
    const geometry::MeshView view = mesh.view();
    std::vector<kdtree::Reference> runs(count_runs(view));
    kdtree::BuildCounters counters;
    runs.resize(run_references(view, 0, runs.size(), runs.data(), counters));
    EXPECT_EQ(counters.touches_prepare, view.faces.size());
    std::vector<int> seen(view.faces.size());
    for (const kdtree::Reference& run : runs) {
      ASSERT_TRUE(run.openable());
      visit(view, run, seen);
    }
    for (std::size_t i = 0; i < mesh.faces.size(); ++i)
      ASSERT_EQ(seen[i], face_bounds(view, i) ? 1 : 0) << i;
  }
}

bool compact(const TestMesh& mesh) {
  kdtree::BuildCounters counters;
  return are_runs_compact(mesh.view(), compute_mesh_stats(mesh.view()).bounds, counters);
}

TEST(Runs, AreNotMadeWhereTheyDoNotHelp) {
  EXPECT_TRUE(compact(waves(100)));
  EXPECT_FALSE(compact(shuffled(waves(100))));
  EXPECT_FALSE(compact(waves(20))) << "few triangles";
  EXPECT_FALSE(compact(TestMesh{}));
}

MeshQuery ask(MeshTree& tree, const geometry::Ray& ray, kdtree::BuildCounters& built) {
  const kdtree::EpochPin pin;
  MeshQuery query = tests::query_of(ray);
  kdtree::WalkCounters walked;
  tests::ask(tree, query, walked, built);
  return query;
}

TEST(Runs, GiveTheSameHitsForLessWork) {
  const TestMesh mesh = waves(200);  // 80,000 triangles
  const geometry::MeshView view = mesh.view();
  std::vector<geometry::Ray> rays;
  tests::Random random(3);
  for (int i = 0; i < 400; ++i) {
    const double x = random.uniform(3, 3.5), z = random.uniform(7, 7.5);
    rays.push_back({{x, 2, z}, {0.01, -1, 0.02}});
  }
  for (const std::string_view name : {"scan-fast", "scan-best"}) {
    const published::AnyBuilder builder = *published::make_builder(name);
    const MeshStats survey = compute_mesh_stats(view);
    MeshTree runs(view, survey, builder, References::kRuns);
    MeshTree soup(view, survey, builder, References::kSoup);
    kdtree::BuildCounters of_runs, of_soup;
    for (const geometry::Ray& ray : rays) {
      const MeshQuery a = ask(runs, ray, of_runs), b = ask(soup, ray, of_soup);
      ASSERT_EQ(a.found, b.found);
      ASSERT_EQ(a.best_t, b.best_t);
      ASSERT_EQ(a.best_primitive, b.best_primitive);
    }
    if (name == "scan-fast") {
      EXPECT_LT(of_runs.touches, of_soup.touches / 2);
    }
    MeshTree full(view, survey, builder, References::kRuns);
    kdtree::BuildCounters counters;
    full.expand_all(counters);
    for (const geometry::Ray& ray : rays)
      ASSERT_EQ(ask(full, ray, counters).best_t, ask(soup, ray, counters).best_t) << name;
  }
}

TEST(Runs, AreScannedWhereNothingIsGrown) {
  const TestMesh mesh = waves(100);
  MeshTree cold(mesh.view(), compute_mesh_stats(mesh.view()), published::default_builder());
  MeshTree grown(mesh.view(), compute_mesh_stats(mesh.view()), published::default_builder());
  kdtree::BuildCounters counters;
  for (const geometry::Ray& ray : tests::rays_at(mesh, 60, 4)) {
    const kdtree::EpochPin pin;
    const MeshQuery expected = ask(grown, ray, counters);
    for (MeshTree* tree : {&cold, &grown}) {
      MeshQuery query = tests::query_of(ray);
      query.cells.growth = lazy::Growth::kNone;
      kdtree::WalkCounters walked;
      tests::ask(*tree, query, walked, counters);
      ASSERT_EQ(query.found, expected.found);
      ASSERT_EQ(query.best_t, expected.best_t);
      ASSERT_EQ(query.best_primitive, expected.best_primitive);
    }
  }
  EXPECT_TRUE(cold.untouched());
}

}  // namespace
}  // namespace sightline::accel::mesh
