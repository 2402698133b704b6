// What packets do at cells of a growing tree that are not built, and what they find there.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/face_references.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/split/scan_split.h"
#include "accel/wide/wide_tree.h"
#include "tests/accel/boxes.h"
#include "tests/accel/mesh/packet_answers.h"

namespace sightline::accel::lazy {
namespace {

using geometry::Ray;
using tests::AskedPacket;
using tests::TestMesh;
using wide::kLanes;

/// Large enough that it is not built at once.
TestMesh soup() { return tests::random_soup(6000, 0.05, 1); }

/// The tree of a mesh, as MeshTree has it.
struct GrowingMesh {
  explicit GrowingMesh(TestMesh from, const split::ScanSplit& rule = split::scan_fast())
      : mesh(std::move(from)), view(mesh.view()) {
    const mesh::MeshStats stats = mesh::compute_mesh_stats(view);
    tree = std::make_unique<LazyTree>(
        geometry::padded(stats.bounds), stats.finite_triangles, split::make_rule(rule),
        mesh::source_of_faces(view, stats.bounds, true, nullptr), &view);
  }

  /// Rays into one corner, of which some cells remain deferred.
  void begin() const {
    for (const Ray& ray : tests::rays_at(mesh, 4, 7)) AskedPacket({&ray, 1}, {}).ask(*tree, view);
  }

  kdtree::GrowthMetrics growth() const {
    const kdtree::EpochPin pin;
    return measure_growth(tree->tree(), mesh.faces.size());
  }

  TestMesh mesh;
  geometry::MeshView view;
  std::unique_ptr<LazyTree> tree;
};

std::size_t expect_exact(const GrowingMesh& of, std::span<const Ray> rays) {
  return tests::expect_exact(*of.tree, of.mesh, rays);
}

TEST(GrowingLeaf, CellsAreBuiltByRays) {
  const GrowingMesh of(soup());
  of.begin();
  const kdtree::GrowthMetrics before = of.growth();
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 16, 5);
  expect_exact(of, rays);
  const kdtree::GrowthMetrics after = of.growth();
  EXPECT_GT(after.cells_built, before.cells_built);
  EXPECT_GT(after.references_built, before.references_built);
  // The same rays again build nothing.
  AskedPacket again(rays, {});
  again.ask(*of.tree, of.view);
  EXPECT_EQ(again.built.cells_expanded, 0u);
  expect_exact(of, tests::rays_at(of.mesh, 160, 6));
  kdtree::BuildCounters built;
  of.tree->expand_all(built);
  EXPECT_EQ(of.growth().cells_deferred, 0u);
  EXPECT_GT(expect_exact(of, tests::rays_at(of.mesh, 64, 4)), 50u);
}

TEST(GrowingLeaf, SkippedCellsAreReported) {
  const GrowingMesh of(soup());
  of.begin();
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 64, 8);
  std::uint32_t reported = 0;
  tests::each_packet(rays, kLanes, [&](std::span<const Ray> part) {
    AskedPacket skipping(part, {}), searching(part, {});
    skipping.cells.growth = Growth::kBuiltOnly;
    searching.cells.growth = Growth::kNone;
    skipping.ask(*of.tree, of.view);
    searching.ask(*of.tree, of.view);
    reported |= skipping.packet->saw_deferred;
    for (std::size_t lane = 0; lane < part.size(); ++lane) {
      EXPECT_EQ(searching.answer(lane), search(of.mesh, part[lane], {}));
      if ((skipping.packet->saw_deferred >> lane & 1) != 0) continue;
      EXPECT_EQ(skipping.answer(lane), search(of.mesh, part[lane], {}));
    }
  });
  EXPECT_NE(reported, 0u);
}

// A scene's tree has no mesh, and ends in lists.
TEST(GrowingLeaf, ATreeOfBoxesEndsInLists) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(500, 0.02, 5);
  LazyTree tree(kdtree::bounds_of(refs), refs.size(), split::default_rule(), source_of(refs));
  kdtree::BuildCounters built;
  tree.expand_all(built);
  const kdtree::EpochPin pin;
  const kdtree::Slot root = kdtree::load(tree.root());
  ASSERT_TRUE(root.is_finished());
  const std::vector<std::uint32_t> held = root.finished()->ids();
  EXPECT_EQ(std::set<std::uint32_t>(held.begin(), held.end()).size(), refs.size());
  EXPECT_FALSE(tree.only());
}

TEST(GrowingLeaf, ATreeOfOneBoxHasItAlone) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(1, 0.02, 5);
  LazyTree tree(kdtree::bounds_of(refs), 1, split::default_rule(), source_of(refs));
  kdtree::BuildCounters built;
  tree.expand_all(built);
  const kdtree::EpochPin pin;
  EXPECT_EQ(tree.only(), refs[0].id);
}

TEST(GrowingLeaf, ThreadsThatGrowAgree) {
  for (int turn = 0; turn < 5; ++turn) {
    const GrowingMesh of(soup());
    const std::vector<Ray> rays = tests::rays_at(of.mesh, 320, 9);
    std::atomic<std::size_t> wrong{0};
    const auto ask_all = [&](bool backward) {
      for (std::size_t i = 0; i < rays.size(); i += kLanes) {
        const std::size_t at = backward ? rays.size() - kLanes - i : i;
        const auto part = std::span<const Ray>(rays).subspan(at, kLanes);
        AskedPacket asked(part, {});
        asked.ask(*of.tree, of.view);
        for (std::size_t lane = 0; lane < part.size(); ++lane) {
          if (!(asked.answer(lane) == search(of.mesh, part[lane], {}))) ++wrong;
        }
      }
    };
    std::thread other(ask_all, true);
    ask_all(false);
    other.join();
    EXPECT_EQ(wrong, 0u);
  }
  kdtree::reclaim();
}

}  // namespace
}  // namespace sightline::accel::lazy
