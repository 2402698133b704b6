// Pieces of trees go and come back: answers stay, bytes are given back, and trees do not grow
// beyond their memory.
#include "accel/lazy/eviction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/face_references.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/split/scan_split.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/mesh/packet_answers.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::accel::lazy {
namespace {

using geometry::Ray;
using kdtree::TreeBytes;
using kdtree::TreeMemory;
using tests::AskedPacket;
using tests::TestMesh;
using wide::kLanes;

constexpr std::uint64_t kMuch = std::uint64_t{1} << 40;

/// The tree of a mesh, as MeshTree has it, in a memory of its own.
struct Growing {
  explicit Growing(TestMesh from, std::uint64_t limit = kMuch, bool runs = true)
      : mesh(std::move(from)), view(mesh.view()), memory(std::make_shared<TreeMemory>(limit)) {
    const mesh::MeshStats stats = mesh::compute_mesh_stats(view);
    tree = std::make_unique<LazyTree>(
        geometry::padded(stats.bounds), stats.finite_triangles, split::default_rule(),
        mesh::source_of_faces(view, stats.bounds, runs, nullptr), &view, memory);
  }

  void build() const {
    kdtree::BuildCounters built;
    tree->expand_all(built);
  }

  /// Returns how many pieces went.
  std::size_t evict_all() const {
    std::size_t evicted = 0;
    const kdtree::EpochPin pin;
    std::vector<Evictable> found;
    tree->list_evictable(found);
    for (const Evictable& piece : found) evicted += tree->evict(piece) > 0 ? 1 : 0;
    return evicted;
  }

  /// As often as rays must come before what was evicted is built again.
  void cast_until_paid(std::span<const Ray> rays) const {
    for (int i = 0; i < 200; ++i) cast(rays);
  }
  kdtree::BuildCounters cast(std::span<const Ray> rays) const {
    kdtree::BuildCounters built;
    tests::each_packet(rays, kLanes, [&](std::span<const Ray> part) {
      AskedPacket asked(part, {});
      asked.ask(*tree, view);
      built += asked.built;
    });
    return built;
  }

  /// What the memory counts is what the tree has.
  void expect_counted() const {
    kdtree::reclaim();
    EXPECT_EQ(memory->held(TreeBytes::kRetired), 0u);
    EXPECT_EQ(memory->held(TreeBytes::kGrowing), 0u);
    EXPECT_EQ(memory->held(), tree->tree().bytes());
    EXPECT_EQ(memory->held(TreeBytes::kLists), tree->tree().deferred_bytes());
    EXPECT_GE(memory->most_held(), memory->held());
  }

  kdtree::TreeMetrics metrics() const {
    const kdtree::EpochPin pin;
    return measure(tree->tree());
  }

  void check() const {
    std::vector<geometry::Aabb> bounds(mesh.faces.size());
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      if (const auto box = mesh::face_bounds(view, i)) bounds[i] = *box;
    }
    const kdtree::EpochPin pin;
    tests::check_tree(tree->tree(), mesh, bounds);
  }

  TestMesh mesh;
  geometry::MeshView view;
  std::shared_ptr<TreeMemory> memory;
  std::unique_ptr<LazyTree> tree;
};

TestMesh evicted_soup() { return tests::random_soup(6000, 0.05, 1); }

template <class Rays>
std::size_t expect_exact(const Growing& of, const Rays& rays) {
  return tests::expect_exact(*of.tree, of.mesh, rays);
}

TEST(Eviction, AFullTreeGoesAndComesBack) {
  const Growing of(evicted_soup());
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 64, 2);
  of.build();
  of.expect_counted();
  EXPECT_TRUE(of.tree->is_complete());
  const std::uint64_t full = of.memory->held();
  for (int turn = 0; turn < 3; ++turn) {
    EXPECT_GT(of.evict_all(), 0u);
    EXPECT_FALSE(of.tree->is_complete());
    of.expect_counted();
    EXPECT_LT(of.memory->held(), full / 4);
    of.check();
    EXPECT_GT(expect_exact(of, rays), 50u);
    of.cast_until_paid(rays);
    EXPECT_GT(of.memory->held(TreeBytes::kSubtrees), 0u);
    of.check();
    expect_exact(of, rays);
    of.build();
    EXPECT_TRUE(of.tree->is_complete());
    of.check();
    of.expect_counted();
  }
}

TEST(Eviction, ATreeThatRaysGrewGoesPieceByPiece) {
  const Growing of(evicted_soup());
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 256, 3);
  expect_exact(of, rays);
  of.expect_counted();
  const std::uint64_t lists = of.memory->held(TreeBytes::kLists);
  const std::size_t pieces = of.evict_all();
  EXPECT_GT(pieces, 8u);
  of.expect_counted();
  EXPECT_EQ(of.memory->held(TreeBytes::kSubtrees), 0u);
  EXPECT_LT(of.memory->held(TreeBytes::kLists), lists + 6000 * 2 * sizeof(std::uint32_t));
  of.check();
  EXPECT_EQ(of.evict_all(), 0u) << "nothing is left";
  expect_exact(of, rays);
  of.cast_until_paid(rays);
  of.check();
  of.expect_counted();
}

TEST(Eviction, ListsBecomeCompact) {
  Growing of(tests::random_soup(20000, 0.02, 4), kMuch, false);
  const std::vector<Ray> ray = tests::rays_at(of.mesh, 1, 5);
  of.cast(ray);
  const std::uint64_t before = of.memory->held(TreeBytes::kLists);
  ASSERT_GT(before, of.mesh.faces.size() * sizeof(kdtree::Reference) / 2);
  of.evict_all();
  of.expect_counted();
  EXPECT_LT(of.memory->held(TreeBytes::kLists), before / 4);
  of.check();
  expect_exact(of, tests::rays_at(of.mesh, 32, 6));
  of.build();
  EXPECT_TRUE(of.tree->is_complete());
  of.check();
}

TEST(Eviction, RunsComeBack) {
  const Growing of(tests::hills(20000, 1));
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 64, 7);
  for (int turn = 0; turn < 3; ++turn) {
    expect_exact(of, rays);
    of.evict_all();
    of.check();
  }
  of.build();
  of.evict_all();
  expect_exact(of, rays);
  of.build();
  of.check();
  of.expect_counted();
}

/// Meshes whose cells hold no less than their parents, or have flat boxes on their faces.
TEST(Eviction, HardMeshesKeepTheirAnswers) {
  for (const TestMesh& mesh :
       {tests::slivers(3000, 1), tests::duplicates(900), tests::planar_sheet(40),
        tests::tiled_cube(4000), tests::fan_about_vertex(2000, 1), tests::stacked_hills(3000, 1),
        tests::random_soup(40, 0.3, 1), tests::with_nonfinite(4000, 3),
        tests::with_nonfinite(900, 1)}) {
    const Growing of(mesh);
    const tests::RaysByRule by_rule(of.mesh, tests::make_hard_rays(of.mesh, 16, 8));
    for (int turn = 0; turn < 2; ++turn) {
      expect_exact(of, by_rule);
      of.evict_all();
      expect_exact(of, by_rule);
      of.build();
      EXPECT_TRUE(of.tree->is_complete());
      expect_exact(of, by_rule);
      of.evict_all();
      of.cast_until_paid(by_rule.rays);
      of.expect_counted();
    }
  }
}

TEST(Eviction, RaysPayBeforeACellIsBuiltAgain) {
  const Growing of(evicted_soup());
  const std::vector<Ray> ray = tests::rays_at(of.mesh, 1, 9);
  of.build();
  of.evict_all();
  std::uint64_t casts = 0;
  while (of.cast(ray).cells_expanded == 0 && casts < 1000) ++casts;
  EXPECT_GT(casts, 4u);
  EXPECT_LT(casts, 200u);
}

TEST(Eviction, WhatWasUsedLastIsWorthMost) {
  const Growing of(tests::random_soup(30000, 0.02, 4));
  of.cast(tests::rays_at(of.mesh, 200, 3));
  for (int i = 0; i < 5; ++i) kdtree::begin_batch();
  const std::vector<Ray> used = tests::rays_at(of.mesh, 4, 11);
  of.cast(used);
  std::vector<Evictable> found;
  const kdtree::EpochPin pin;
  of.tree->list_evictable(found);
  std::uint64_t least = ~std::uint64_t{0}, most = 0;
  for (const Evictable& piece : found) {
    const kdtree::Slot now = kdtree::load(*piece.slot);
    if (!now.is_finished()) continue;
    (now.finished()->last_use.age() == 0 ? least : most) = now.finished()->last_use.age() == 0
                                                               ? std::min(least, piece.value)
                                                               : std::max(most, piece.value);
  }
  EXPECT_GT(most, 0u);
  EXPECT_LT(least, ~std::uint64_t{0});
  EXPECT_GT(least, most);
}

TEST(Eviction, ATreeDoesNotGrowBeyondItsMemory) {
  const Growing whole(evicted_soup());
  whole.build();
  const std::uint64_t limit = whole.memory->held() / 4;
  const Growing of(evicted_soup(), limit);
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 160, 12);
  for (int turn = 0; turn < 4; ++turn) {
    expect_exact(of, rays);
    // One expansion: the lists of all of the mesh, or the blocks of a cell with its list.
    EXPECT_LT(of.memory->most_held(), limit + 2 * of.mesh.faces.size() * sizeof(kdtree::Reference));
    of.build();
    EXPECT_FALSE(of.tree->is_complete());
    const std::uint64_t before = of.memory->held();
    EXPECT_EQ(of.cast(rays).cells_expanded == 0, before >= limit);
    of.evict_all();
    of.expect_counted();
    EXPECT_LT(of.memory->held(), limit);
    of.check();
  }
}

TEST(Eviction, EvictionIsRequestedWhenTreesMayNotGrow) {
  const Growing of(evicted_soup(), 1);
  of.cast(tests::rays_at(of.mesh, 16, 13));
  std::thread waiting([&] { of.memory->wait_for_request(); });
  of.cast(tests::rays_at(of.mesh, 16, 13));
  of.memory->request_eviction();
  waiting.join();
}

TEST(Eviction, WhatOthersHoldIsNotForTrees) {
  TreeMemory memory(1000);
  memory.add_others(600);
  EXPECT_EQ(memory.limit(), 400u);
  memory.add(TreeBytes::kLists, 399);
  EXPECT_TRUE(memory.may_grow());
  EXPECT_FALSE(memory.may_build_ahead());
  memory.move(TreeBytes::kLists, TreeBytes::kRetired, 399);
  memory.add(TreeBytes::kNodes, 1);
  EXPECT_FALSE(memory.may_grow());
  memory.add_others(std::uint64_t{0} - 600);
  EXPECT_TRUE(memory.may_build_ahead());
  memory.add(TreeBytes::kRetired, std::uint64_t{0} - 399);
  EXPECT_EQ(memory.held(), 1u);
  EXPECT_EQ(memory.most_held(), 400u);
}

TEST(Eviction, ThreadsCastWhileAnotherEvicts) {
  for (const bool build : {false, true}) {
    const Growing of(evicted_soup());
    const std::vector<Ray> rays = tests::rays_at(of.mesh, 320, 9);
    std::vector<tests::Answer> expected;
    for (const Ray& ray : rays) expected.push_back(search(of.mesh, ray, {}));
    std::atomic<std::size_t> wrong{0};
    std::atomic<int> casting{2}, turns{0};
    std::atomic<std::size_t> evicted{0};
    const auto cast = [&](bool backward) {
      for (int turn = 0; turn < 20 || evicted == 0; ++turn) {
        for (std::size_t i = 0; i < rays.size(); i += kLanes) {
          const std::size_t at = backward ? rays.size() - kLanes - i : i;
          AskedPacket asked(std::span<const Ray>(rays).subspan(at, kLanes), {});
          asked.ask(*of.tree, of.view);
          for (std::size_t lane = 0; lane < kLanes; ++lane) {
            if (!(asked.answer(lane) == expected[at + lane])) ++wrong;
          }
        }
        if (build) of.build();
        ++turns;
      }
      --casting;
    };
    std::thread one(cast, true), other(cast, false);
    // Once a turn: a build that is undone all the time does not end.
    for (int seen = -1; casting > 0;) {
      if (seen == turns) {
        std::this_thread::yield();
        continue;
      }
      seen = turns;
      evicted += of.evict_all();
      kdtree::reclaim();
    }
    one.join();
    other.join();
    EXPECT_EQ(wrong, 0u);
    of.expect_counted();
    of.check();
  }
}

TEST(Eviction, MemoryEndsAtNothing) {
  std::shared_ptr<TreeMemory> memory;
  {
    const Growing of(evicted_soup());
    memory = of.memory;
    of.cast(tests::rays_at(of.mesh, 100, 3));
    of.evict_all();
    of.build();
    EXPECT_GT(memory->held(), 0u);
  }
  kdtree::reclaim();
  EXPECT_EQ(memory->held(), 0u);
}

}  // namespace
}  // namespace sightline::accel::lazy
