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
#include "tests/support/rounds.h"

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

/// What the rule says of one ray.
struct Expected {
  std::vector<std::uint32_t> primitives;
  std::vector<ListedHit> list;
};

Expected search_exactly(const TestMesh& mesh, const Ray& ray, Culling culling) {
  const geometry::LocalRay local = *make_local_ray(ray.origin, ray.direction);
  Expected expected;
  for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) {
    if (!face_bounds(mesh.view(), i)) continue;
    const geometry::Face& f = mesh.faces[i];
    const geometry::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]],
                          &c = mesh.vertices[f[2]];
    const std::optional<double> t = intersect(local, a, b, c);
    if (!t || is_culled(culling, local, a, b, c)) continue;
    const double world = *t * local.unit;
    if (!(world >= ray.tmin && world <= ray.tmax)) continue;
    expected.primitives.push_back(i);
    expected.list.push_back({world, kNode, i, 0});
  }
  std::sort(expected.list.begin(), expected.list.end());
  expected.list.resize(std::min(expected.list.size(), kListed));
  return expected;
}

/// What one ray collects.
struct Found {
  UniqueHits<ListedHit> list{kListed};
  UniqueHits<std::uint32_t> primitives;
};

void expect_all(Found& found, const Expected& expected) {
  EXPECT_TRUE(std::ranges::equal(found.primitives.sorted(), expected.primitives));
  EXPECT_TRUE(std::ranges::equal(found.list.sorted(), expected.list));
}

/// The questions of one kind of culling, and their answers.
struct Questions {
  Questions(const TestMesh& mesh, std::span<const Ray> asked, Culling side)
      : rays(asked), culling(side) {
    for (const Ray& ray : rays) expected.push_back(search_exactly(mesh, ray, culling));
  }

  std::span<const Ray> rays;
  Culling culling;
  std::vector<Expected> expected;
};

/// Asks once for each of the two sinks.
template <class Ask>
void for_both(Found& found, const Ask& ask) {
  ask(HitSink{.list = &found.list});
  ask(HitSink{.primitives = &found.primitives});
}

void ask_alone(MeshTree& tree, const Questions& questions, lazy::Growth growth) {
  const kdtree::EpochPin pin;
  for (std::size_t i = 0; i < questions.rays.size(); ++i) {
    Found found;
    for_both(found, [&](const HitSink& sink) {
      tests::MeshQuery query = tests::query_of(questions.rays[i]);
      query.goal = wide::Goal::kEvery;
      query.sink = sink;
      query.cells.growth = growth;
      query.culling = questions.culling;
      query.node = kNode;
      kdtree::WalkCounters walked;
      kdtree::BuildCounters built;
      tests::ask(tree, query, walked, built);
    });
    expect_all(found, questions.expected[i]);
  }
}

void ask_packet(MeshTree& tree, std::span<const Ray> rays, Culling culling, lazy::Growth growth,
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
  cells.growth = growth;
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;
  tree.query(*packet, (2u << (rays.size() - 1)) - 1, cells, walked, built);
}

void ask_packets(MeshTree& tree, const Questions& questions, lazy::Growth growth) {
  const kdtree::EpochPin pin;
  for (std::size_t first = 0; first < questions.rays.size(); first += kLanes) {
    const auto part =
        questions.rays.subspan(first, std::min(kLanes, questions.rays.size() - first));
    std::array<Found, kLanes> found;
    std::array<HitSink, kLanes> lists, primitives;
    for (std::size_t i = 0; i < kLanes; ++i) {
      lists[i].list = &found[i].list;
      primitives[i].primitives = &found[i].primitives;
    }
    ask_packet(tree, part, questions.culling, growth, lists);
    ask_packet(tree, part, questions.culling, growth, primitives);
    for (std::size_t i = 0; i < part.size(); ++i)
      expect_all(found[i], questions.expected[first + i]);
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
  const std::vector<Ray> rays_ =
      tests::make_hard_rays(mesh_, tests::rounds(3) * tests::kHardRayKinds, 32);
};

TEST_P(AllHits, OfRaysAloneAndOfPacketsEqualTheRule) {
  const auto growing_alone = make_tree(), growing = make_tree(), searched = make_tree();
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
    const Questions questions(mesh_, rays_, culling);
    for (const lazy::Growth growth : {lazy::Growth::kFirstTouch, lazy::Growth::kNone}) {
      ask_alone(*growing_alone, questions, growth);
      ask_packets(*growing, questions, growth);
    }
    if (culling != Culling::kNone) continue;
    ask_alone(*searched, questions, lazy::Growth::kNone);
    ask_packets(*searched, questions, lazy::Growth::kNone);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, AllHits,
                         tests::alternating_simd_targets(tests::hard_meshes().size()),
                         [](const auto& test) {
                           std::string name(tests::hard_meshes()[std::get<1>(test.param)].name);
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); },
                               '_');
                           return std::string(hwy::TargetName(std::get<0>(test.param))) + "_" +
                                  name;
                         });

}  // namespace
}  // namespace sightline::accel::mesh
