// Rays by themselves and in packets find all hits that the hit rule finds over every triangle of
// hard meshes, on every SIMD target, however much of the tree is built.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/epoch.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_tree.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/mesh_query.h"

namespace sightline::accel::mesh {
namespace {

using geometry::Culling;
using geometry::Ray;
using tests::TestMesh;
using wide::HitSink;
using wide::kLanes;
using wide::ListedHit;
using wide::UniqueHits;

constexpr std::uint64_t kNode = 7;
/// Fewer than many rays hit.
constexpr std::size_t kListed = 3;

std::vector<ListedHit> search_exactly(const TestMesh& mesh, const Ray& ray, Culling culling) {
  const geometry::LocalRay local = *make_local_ray(ray.origin, ray.direction);
  std::vector<ListedHit> hits;
  for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) {
    if (!face_bounds(mesh.view(), i)) continue;
    const geometry::Face& f = mesh.faces[i];
    const geometry::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]],
                          &c = mesh.vertices[f[2]];
    const std::optional<double> t = intersect(local, a, b, c);
    if (!t || is_culled(culling, local, a, b, c)) continue;
    const double world = *t * local.unit;
    if (world >= ray.tmin && world <= ray.tmax) hits.push_back({world, kNode, i, 0});
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

/// What one ray collects.
struct Found {
  UniqueHits<ListedHit> list{kListed};
  UniqueHits<std::uint32_t> primitives;
};

void expect_all(Found& found, const TestMesh& mesh, const Ray& ray, Culling culling) {
  std::vector<ListedHit> expected = search_exactly(mesh, ray, culling);
  std::vector<std::uint32_t> ids;
  for (const ListedHit& hit : expected) ids.push_back(hit.primitive);
  std::sort(ids.begin(), ids.end());
  const auto counted = found.primitives.sorted();
  EXPECT_TRUE(std::equal(counted.begin(), counted.end(), ids.begin(), ids.end()));
  expected.resize(std::min(expected.size(), kListed));
  const auto listed = found.list.sorted();
  EXPECT_TRUE(std::equal(listed.begin(), listed.end(), expected.begin(), expected.end()));
}

/// Asks once for each of the two sinks.
template <class Ask>
void for_both(Found& found, const Ask& ask) {
  ask(HitSink{.list = &found.list});
  ask(HitSink{.primitives = &found.primitives});
}

void ask_alone(MeshTree& tree, const TestMesh& mesh, std::span<const Ray> rays, Culling culling,
               OnDeferred on_deferred) {
  const kdtree::EpochPin pin;
  for (const Ray& ray : rays) {
    Found found;
    for_both(found, [&](const HitSink& sink) {
      tests::MeshQuery query = tests::query_of(ray);
      query.goal = wide::Goal::kEvery;
      query.sink = sink;
      query.cells.on_deferred = on_deferred;
      query.culling = culling;
      query.node = kNode;
      kdtree::WalkCounters walked;
      kdtree::BuildCounters built;
      tests::ask(tree, query, walked, built);
    });
    expect_all(found, mesh, ray, culling);
  }
}

void ask_packet(MeshTree& tree, std::span<const Ray> rays, Culling culling, OnDeferred on_deferred,
                std::span<const HitSink> sinks) {
  const auto packet = std::make_unique<wide::Packet>();
  wide::BestHits best;
  best.clear();
  packet->best = &best;
  packet->goal = wide::Goal::kEvery;
  packet->sinks = sinks;
  packet->culling = culling;
  packet->node = kNode;
  packet->work.fill(0);
  tests::set_rays(rays, packet->rays);
  lazy::CellQuery cells;
  cells.on_deferred = on_deferred;
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;
  tree.query(*packet, (2u << (rays.size() - 1)) - 1, cells, walked, built);
}

void ask_packets(MeshTree& tree, const TestMesh& mesh, std::span<const Ray> rays, Culling culling,
                 OnDeferred on_deferred) {
  const kdtree::EpochPin pin;
  for (; !rays.empty(); rays = rays.subspan(std::min(kLanes, rays.size()))) {
    const auto part = rays.first(std::min(kLanes, rays.size()));
    std::array<Found, kLanes> found;
    std::array<HitSink, kLanes> lists, primitives;
    for (std::size_t i = 0; i < kLanes; ++i) {
      lists[i].list = &found[i].list;
      primitives[i].primitives = &found[i].primitives;
    }
    ask_packet(tree, part, culling, on_deferred, lists);
    ask_packet(tree, part, culling, on_deferred, primitives);
    for (std::size_t i = 0; i < part.size(); ++i) expect_all(found[i], mesh, part[i], culling);
  }
}

class AllHits : public ::testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(std::get<0>(GetParam())); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  /// Not yet begun.
  std::unique_ptr<MeshTree> make_tree() const {
    return std::make_unique<MeshTree>(mesh_.view(), compute_mesh_stats(mesh_.view()),
                                      TreeBuilder{});
  }

  /// More triangles than become blocks at once.
  const TestMesh mesh_ = tests::hard_meshes()[std::get<1>(GetParam())].make(1200, 31);
  const std::vector<Ray> rays_ = tests::make_hard_rays(mesh_, 3 * tests::kHardRayKinds, 32);
};

TEST_P(AllHits, OfRaysAloneEqualTheRule) {
  const auto growing = make_tree(), searched = make_tree();
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
    ask_alone(*growing, mesh_, rays_, culling, OnDeferred::kExpand);
    ask_alone(*growing, mesh_, rays_, culling, OnDeferred::kScan);
  }
  ask_alone(*searched, mesh_, rays_, Culling::kNone, OnDeferred::kScan);
}

TEST_P(AllHits, OfPacketsEqualTheRule) {
  const auto growing = make_tree(), searched = make_tree();
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
    ask_packets(*growing, mesh_, rays_, culling, OnDeferred::kExpand);
    ask_packets(*growing, mesh_, rays_, culling, OnDeferred::kScan);
  }
  ask_packets(*searched, mesh_, rays_, Culling::kNone, OnDeferred::kScan);
}

INSTANTIATE_TEST_SUITE_P(
    Every, AllHits,
    ::testing::Combine(tests::every_simd_target(),
                       ::testing::Range(std::size_t{0}, tests::hard_meshes().size())),
    [](const auto& test) {
      std::string name(tests::hard_meshes()[std::get<1>(test.param)].name);
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
      return std::string(hwy::TargetName(std::get<0>(test.param))) + "_" + name;
    });

}  // namespace
}  // namespace sightline::accel::mesh
