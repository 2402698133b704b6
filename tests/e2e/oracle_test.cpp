// Real scenes through importer, client, wire and server: every hit equals brute force, lazy or
// full.
#include <gtest/gtest.h>

#include <cstring>
#include <ostream>
#include <string>
#include <vector>

#include "tests/bench/scenes/load_scene.h"
#include "tests/e2e/served_scene.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;

// Half overview rays, half random ones.
constexpr SceneFile kOracleScenes[] = {
    {"bunny", "bunny.ply", 20'000},
    {"sponza", "sponza.glb", 20'000},
    {"sibenik", "sibenik.ply", 20'000},
    {"wine", "wine.dae", 20'000},
    {"reciprocating_saw", "reciprocating_saw.glb", 20'000},
    {"torcs_forza", "torcs_forza.glb", 20'000},
    {"fzk_haus", "fzk_haus.ifc", 20'000},
    {"sterngarten", "sterngarten.obj", 20'000},
    {"dragon", "dragon.ply", 2'000},
};

// All columns of an answer, in memory that the client fills.
struct Columns {
  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> barycentric, normal;
  std::vector<std::uint8_t> hit;

  explicit Columns(std::size_t n)
      : t(n), node(n), primitive(n), barycentric(2 * n), normal(3 * n), hit(n) {}

  client::HitColumns view() {
    return {.t = t,
            .node = node,
            .primitive = primitive,
            .barycentric = barycentric,
            .normal = normal,
            .hit = hit};
  }

  std::vector<Hit> hits() const {
    std::vector<Hit> rows(t.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].t = t[i];
      rows[i].node = node[i];
      rows[i].primitive = primitive[i];
      rows[i].u = barycentric[2 * i];
      rows[i].v = barycentric[2 * i + 1];
      rows[i].normal = {normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]};
      rows[i].state = static_cast<accel::geometry::HitState>(hit[i]);
    }
    return rows;
  }
};

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

class OracleTest : public ServedScene, public testing::WithParamInterface<SceneFile> {
 protected:
  client::CastReport cast(const std::vector<Ray>& rays, client::BuildMode build, Columns& columns) {
    std::vector<double> origins, directions, tmin, tmax;
    for (const Ray& ray : rays) {
      origins.insert(origins.end(), {ray.origin.x, ray.origin.y, ray.origin.z});
      directions.insert(directions.end(), {ray.direction.x, ray.direction.y, ray.direction.z});
      tmin.push_back(ray.tmin);
      tmax.push_back(ray.tmax);
    }
    client::CastOptions options;
    options.build = build;
    const auto report = client_->cast_stream(
        kScene, client::RayColumns<const double>{origins, directions, tmin, tmax}, columns.view(),
        options);
    EXPECT_TRUE(report.ok()) << report.error().message;
    return report.ok() ? *report : client::CastReport{};
  }
};

TEST_P(OracleTest, HitsThroughTheServerEqualBruteForceLazyAndFull) {
  ASSERT_NO_FATAL_FAILURE(serve(GetParam().file));
  if (IsSkipped()) return;
  const auto scene = bench::load_scene(file_.string());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const std::vector<Ray> rays = mixed_rays(*scene, GetParam().rays / divisor());

  Columns lazy(rays.size());
  const client::CastReport report = cast(rays, client::BuildMode::kLazy, lazy);
  EXPECT_EQ(report.rays, rays.size());
  EXPECT_EQ(report.invalid, 0u);

  const BruteForce oracle(placed_meshes(*scene));
  const Comparison result = compare(rays, lazy.hits(), oracle, {.surface = true});
  EXPECT_EQ(result.mismatches, 0u) << result.report();
  EXPECT_EQ(result.edges, 0u) << result.report();
  EXPECT_EQ(result.surface_errors, 0u) << result.report();
  EXPECT_EQ(result.hits, report.hits);
  EXPECT_GT(result.hits, rays.size() / 20) << result.report();
  RecordProperty("comparison", result.report());

  Columns full(rays.size());
  cast(rays, client::BuildMode::kFull, full);
  EXPECT_TRUE(same_bytes(lazy.t, full.t));
  EXPECT_TRUE(same_bytes(lazy.node, full.node));
  EXPECT_TRUE(same_bytes(lazy.primitive, full.primitive));
  EXPECT_TRUE(same_bytes(lazy.barycentric, full.barycentric));
  EXPECT_TRUE(same_bytes(lazy.normal, full.normal));
  EXPECT_TRUE(same_bytes(lazy.hit, full.hit));
}

INSTANTIATE_TEST_SUITE_P(Scenes, OracleTest, testing::ValuesIn(kOracleScenes),
                         [](const auto& scene) { return std::string(scene.param.name); });

}  // namespace
}  // namespace sightline::tests
