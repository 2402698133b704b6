// Packets in trees of meshes at every stage of growth answer as a search of all triangles.
#include "accel/mesh/face_test.h"

#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "accel/kdtree/tree_metrics.h"
#include "accel/published/any_builder.h"
#include "tests/accel/mesh/packet_answers.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::accel::mesh {
namespace {

using geometry::Ray;
using tests::Answer;
using tests::AskedPacket;
using tests::kQuestions;
using tests::Question;
using tests::TestMesh;

std::unique_ptr<MeshTree> tree_over(const TestMesh& mesh, const published::AnyBuilder& builder) {
  return std::make_unique<MeshTree>(mesh.view(), compute_mesh_stats(mesh.view()), builder);
}

std::unique_ptr<MeshTree> tree_over(const TestMesh& mesh) {
  return tree_over(mesh, published::default_builder());
}

/// Hard ones, some from one point side by side, some that are too far away for floats.
std::vector<Ray> packet_rays_for(const TestMesh& mesh) {
  std::vector<Ray> rays = tests::make_hard_rays(mesh, 64, 5);
  const geometry::Vec3d target(mesh.vertices[0]), from = target + geometry::Vec3d{3, 2, 5};
  for (std::size_t i = 0; i < 32; ++i) {
    const geometry::Vec3d to(mesh.vertices[i * 17 % mesh.vertices.size()]);
    if (to != from) rays.push_back({from, to - from});
  }
  rays.push_back({target + geometry::Vec3d{0, 0, 0x1p+62}, {0, 0, -1}});
  rays.push_back({target - geometry::Vec3d{0x1p+70, 0, 0}, {1, 0, 0}});
  return rays;
}

/// A mesh, rays at it, and what they hit by the rule.
struct AskedMesh {
  explicit AskedMesh(TestMesh of)
      : mesh(std::move(of)), by_rule(mesh, packet_rays_for(mesh)), rays(by_rule.rays) {}

  TestMesh mesh;
  tests::RaysByRule by_rule;
  std::span<const Ray> rays;
};

std::vector<TestMesh> meshes() {
  TestMesh far = tests::random_soup(1200, 0.1, 3);
  for (geometry::Vec3f& v : far.vertices) v = {v.x + 1e6f, v.y - 1e6f, v.z + 3e5f};
  return {tests::single_triangle(), tests::duplicates(100),  tests::random_soup(2500, 0.08, 1),
          tests::icosphere(4),      tests::slivers(1500, 2), far};
}

/// Half of the rays, one at a time, in their part of the mesh.
void grow(MeshTree& tree, std::span<const Ray> rays) {
  for (const Ray& ray : rays.first(rays.size() / 2)) AskedPacket({&ray, 1}, {}).ask(tree);
}

/// Asks in packets of all sizes, each question.
void expect_exact(MeshTree& tree, const AskedMesh& of,
                  lazy::Growth growth = lazy::Growth::kFirstTouch) {
  for (const Question& question : kQuestions) {
    std::size_t size = 1, hits = 0;
    for (std::size_t i = 0; i < of.rays.size(); i += size, size = size % wide::kLanes + 1) {
      const auto part = of.rays.subspan(i, std::min(size, of.rays.size() - i));
      AskedPacket asked(part, question);
      asked.cells.growth = growth;
      asked.ask(tree);
      ASSERT_FALSE(asked.packet->stopped);
      ASSERT_EQ(asked.packet->saw_deferred & ~asked.lanes(), 0u);
      ASSERT_EQ(asked.work(), asked.walked.steps + asked.walked.tests);
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        ASSERT_EQ(asked.answer(lane), of.by_rule.expected(i + lane, question))
            << "lane " << lane << " of " << part.size();
        hits += asked.answer(lane).found ? 1 : 0;
      }
    }
    ASSERT_GT(hits, 0u);
  }
}

/// A ray that has met no deferred cell has its answer; before the first ray, all that enter meet
/// one.
void expect_skipped_cells_are_reported(MeshTree& untouched, MeshTree& half, const AskedMesh& of) {
  for (const Question& question : kQuestions) {
    for (std::size_t i = 0; i < of.rays.size(); i += wide::kLanes) {
      const auto part = of.rays.subspan(i, std::min(wide::kLanes, of.rays.size() - i));
      AskedPacket at_first(part, question), later(part, question);
      at_first.cells.growth = later.cells.growth = lazy::Growth::kBuiltOnly;
      at_first.ask(untouched);
      later.ask(half);
      EXPECT_EQ(at_first.best->found, 0u);
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        const Answer expected = of.by_rule.expected(i + lane, question);
        EXPECT_TRUE(!expected.found || (at_first.packet->saw_deferred >> lane & 1) != 0);
        if ((later.packet->saw_deferred >> lane & 1) != 0) continue;
        EXPECT_EQ(later.answer(lane), expected);
      }
    }
  }
  EXPECT_TRUE(untouched.untouched());
}

void expect_all_is_built(MeshTree& finished, const AskedMesh& of) {
  AskedPacket asked(of.rays.first(wide::kLanes), {});
  asked.cells.growth = lazy::Growth::kBuiltOnly;
  asked.ask(finished);
  EXPECT_EQ(asked.packet->saw_deferred, 0u);
  EXPECT_EQ(asked.built.cells_expanded, 0u);
}

class FaceTests : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, FaceTests, tests::every_simd_target(), tests::simd_target_name);

TEST_P(FaceTests, HoweverMuchOfTheTreeIsBuilt) {
  for (TestMesh& mesh : meshes()) {
    const AskedMesh of(std::move(mesh));
    const auto grown = tree_over(of.mesh), paid = tree_over(of.mesh), half = tree_over(of.mesh),
               untouched = tree_over(of.mesh), finished = tree_over(of.mesh);
    expect_exact(*grown, of);
    for (int again = 0; again < 2; ++again) expect_exact(*paid, of, lazy::Growth::kDemand);
    expect_exact(*untouched, of, lazy::Growth::kNone);
    grow(*half, of.rays);
    expect_skipped_cells_are_reported(*untouched, *half, of);
    expect_exact(*half, of, lazy::Growth::kNone);
    expect_exact(*half, of);
    kdtree::BuildCounters built;
    finished->expand_all(built);
    expect_exact(*finished, of);
    expect_all_is_built(*finished, of);
  }
}

TEST_P(FaceTests, InTreesThatAreBuiltWhole) {
  published::ScanBuilder plain = split::scan_fast();
  plain.blocks = false;
  const std::vector<published::AnyBuilder> builders{published::KdBuilder(plain),
                                                    *published::make_builder("bvh-sweep")};
  const AskedMesh of(tests::random_soup(1500, 0.08, 1));
  for (const published::AnyBuilder& builder : builders)
    expect_exact(*tree_over(of.mesh, builder), of);
}

TEST_P(FaceTests, SearchedCellsAreReported) {
  const TestMesh mesh = tests::random_soup(2500, 0.08, 1);
  const auto tree = tree_over(mesh);
  const std::vector<Ray> rays = tests::rays_at(mesh, wide::kLanes, 2);
  AskedPacket searched(rays, {}), built(rays, {});
  searched.cells.growth = lazy::Growth::kNone;
  searched.ask(*tree);
  EXPECT_EQ(searched.packet->saw_deferred, searched.lanes());
  built.ask(*tree);
  EXPECT_EQ(built.packet->saw_deferred, 0u);
  EXPECT_GT(built.built.cells_expanded, 0u);
}

// Equal hits are those of the least node, then of the least triangle, whichever tree comes first.
TEST_P(FaceTests, HitsOfSeveralTreesAreCompared) {
  const TestMesh mesh = tests::random_soup(1500, 0.08, 1);
  const std::vector<Ray> rays = packet_rays_for(mesh);
  const auto first = tree_over(mesh), second = tree_over(mesh);
  for (const bool second_is_less : {false, true}) {
    tests::each_packet(rays, wide::kLanes, [&](std::span<const Ray> part) {
      AskedPacket asked(part, {});
      asked.packet->node = second_is_less ? 9 : 3;
      asked.ask(*first);
      asked.packet->node = second_is_less ? 3 : 9;
      asked.packet->instance = 1;
      asked.ask(*second);
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        EXPECT_EQ(asked.answer(lane), search(mesh, part[lane], Question{}));
        if (!asked.answer(lane).found) continue;
        EXPECT_EQ(asked.best->node[lane], 3u);
        EXPECT_EQ(asked.best->instance[lane], second_is_less ? 1u : 0u);
      }
    });
  }
}

TEST_P(FaceTests, OnlyTheLanesThatAreAskedFor) {
  const TestMesh mesh = tests::icosphere(3);
  const auto tree = tree_over(mesh);
  const std::vector<Ray> rays(wide::kLanes, Ray{{0, 0, 3}, {0, 0, -1}});
  for (const std::uint32_t lanes : {0u, 1u, 0x8000u, 0x0ff0u, 0x5555u}) {
    AskedPacket asked(rays, {});
    const kdtree::EpochPin pin;
    tree->query(*asked.packet, lanes, asked.cells, asked.walked, asked.built);
    EXPECT_EQ(asked.best->found, lanes);
    for (std::size_t lane = 0; lane < wide::kLanes; ++lane)
      EXPECT_EQ(asked.packet->work[lane] > 0, (lanes >> lane & 1) != 0);
  }
}

TEST_P(FaceTests, ACancelledPacketStops) {
  const TestMesh mesh = tests::random_soup(5000, 0.05, 1);
  const auto tree = tree_over(mesh);
  const std::atomic<bool> cancelled{true};
  AskedPacket asked(tests::rays_at(mesh, wide::kLanes, 2), {});
  asked.cells.cancelled = &cancelled;
  asked.ask(*tree);
  EXPECT_TRUE(asked.packet->stopped);
  EXPECT_TRUE(tree->untouched());
}

}  // namespace
}  // namespace sightline::accel::mesh
