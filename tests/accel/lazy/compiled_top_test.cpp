// The wide nodes over a growing tree: when they are made, what they lead to, and that packets
// answer through them as without.
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
  explicit GrowingMesh(TestMesh from) : mesh(std::move(from)), view(mesh.view()) {
    const mesh::MeshStats stats = mesh::compute_mesh_stats(view);
    tree = std::make_unique<LazyTree>(
        geometry::padded(stats.bounds), stats.finite_triangles, split::default_rule(),
        mesh::source_of_faces(view, stats.bounds, true, nullptr), &view);
  }

  wide::Child entry() const {
    const kdtree::EpochPin pin;
    return tree->entry();
  }
  bool has_top() const { return tree->tree().top() != nullptr; }
  std::uint64_t steps_to_top() const { return kStepsPerNode * 2 * tree->tree().pairs(); }

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

TEST(CompiledTop, IsMadeAfterEnoughSteps) {
  const GrowingMesh of(soup());
  EXPECT_EQ(of.entry().bits(), wide::Child::slot(&of.tree->root()).bits());
  // There is nothing to compile yet.
  of.tree->count_steps(1'000'000);
  EXPECT_FALSE(of.has_top());
  of.begin();
  ASSERT_GT(of.tree->tree().pairs(), 0u);
  ASSERT_GT(of.growth().cells_deferred, 0u);
  of.tree->count_steps(of.steps_to_top());
  ASSERT_TRUE(of.entry().is_node());
  const wide::WideNode* top = of.entry().node();
  of.tree->count_steps(of.steps_to_top() - 1);
  EXPECT_EQ(of.entry().node(), top);
  of.tree->count_steps(1);
  EXPECT_NE(of.entry().node(), top) << "it is compiled again";
}

TEST(CompiledTop, IsMadeByRaysAlone) {
  const GrowingMesh of(soup());
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 2000, 3);
  std::size_t asked = 0;
  for (; asked < rays.size() && !of.entry().is_node(); ++asked)
    AskedPacket({&rays[asked], 1}, {}).ask(*of.tree, of.view);
  EXPECT_GT(asked, 1u);
  EXPECT_TRUE(of.entry().is_node());
}

TEST(CompiledTop, IsMadeByAFullBuildOfWhatRaysHaveBegun) {
  const GrowingMesh of(soup());
  of.begin();
  kdtree::BuildCounters built;
  of.tree->expand_all(built);
  EXPECT_TRUE(of.entry().is_node());
  EXPECT_GT(expect_exact(of, tests::rays_at(of.mesh, 64, 4)), 50u);
}

TEST(CompiledTop, DeferredCellsBelowItAreBuiltByRays) {
  const GrowingMesh of(soup());
  of.begin();
  of.tree->count_steps(of.steps_to_top());
  ASSERT_TRUE(of.entry().is_node());
  const wide::WideNode* top = of.entry().node();
  const kdtree::GrowthMetrics before = of.growth();
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 16, 5);
  expect_exact(of, rays);
  const kdtree::GrowthMetrics after = of.growth();
  EXPECT_GT(after.cells_built, before.cells_built);
  EXPECT_GT(after.references_built, before.references_built);
  // The same rays again build nothing, and a new top finds what they find.
  AskedPacket again(rays, {});
  again.ask(*of.tree, of.view);
  EXPECT_EQ(again.built.cells_expanded, 0u);
  of.tree->count_steps(of.steps_to_top());
  EXPECT_NE(of.entry().node(), top);
  expect_exact(of, tests::rays_at(of.mesh, 160, 6));
  kdtree::BuildCounters built;
  of.tree->expand_all(built);
  EXPECT_EQ(of.growth().cells_deferred, 0u);
  EXPECT_GT(expect_exact(of, tests::rays_at(of.mesh, 64, 4)), 50u);
}

TEST(CompiledTop, SkippedCellsBelowItAreReported) {
  const GrowingMesh of(soup());
  of.begin();
  of.tree->count_steps(of.steps_to_top());
  ASSERT_TRUE(of.entry().is_node());
  const std::vector<Ray> rays = tests::rays_at(of.mesh, 64, 8);
  std::uint32_t reported = 0;
  tests::each_packet(rays, kLanes, [&](std::span<const Ray> part) {
    AskedPacket skipping(part, {}), searching(part, {});
    skipping.cells.on_deferred = OnDeferred::kSkip;
    searching.cells.on_deferred = OnDeferred::kScan;
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

void list_slots(wide::Child at, std::vector<const kdtree::AtomicSlot*>& slots,
                std::set<const wide::WideNode*>& nodes) {
  if (at.is_block()) return;
  if (!at.is_node()) return slots.push_back(at.slot());
  if (!nodes.insert(at.node()).second) return;
  for (const wide::Child child : at.node()->children) {
    if (child) list_slots(child, slots, nodes);
  }
}

void list_deferred(const kdtree::KdTree& tree, const kdtree::AtomicSlot& slot,
                   std::set<const kdtree::AtomicSlot*>& out) {
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_deferred()) out.insert(&slot);
  if (!now.is_binary()) return;
  list_deferred(tree, tree.children(now)[0], out);
  list_deferred(tree, tree.children(now)[1], out);
}

TEST(CompiledTop, LeadsToEveryDeferredSlotOnce) {
  const GrowingMesh of(soup());
  of.begin();
  of.tree->count_steps(of.steps_to_top());
  const kdtree::EpochPin pin;
  std::vector<const kdtree::AtomicSlot*> slots;
  std::set<const wide::WideNode*> nodes;
  list_slots(of.entry(), slots, nodes);
  std::set<const kdtree::AtomicSlot*> expected;
  list_deferred(of.tree->tree(), of.tree->root(), expected);
  EXPECT_GT(expected.size(), 1u);
  EXPECT_EQ(slots.size(), expected.size());
  EXPECT_EQ(std::set<const kdtree::AtomicSlot*>(slots.begin(), slots.end()), expected);
}

TEST(CompiledTop, ItsMemoryIsTheTrees) {
  const GrowingMesh of(soup());
  of.begin();
  const kdtree::KdTree& tree = of.tree->tree();
  const std::uint64_t before = tree.bytes(), cells = of.growth().cells_built;
  for (int i = 0; i < 3; ++i) {
    of.tree->count_steps(of.steps_to_top());
    ASSERT_NE(tree.top(), nullptr);
    EXPECT_EQ(tree.bytes(), before + tree.top()->size_in_bytes());
    EXPECT_GE(tree.bytes_peak(), tree.bytes());
  }
  // The metrics are those of the nodes that it stands for.
  EXPECT_EQ(of.growth().cells_built, cells);
}

TEST(CompiledTop, ATreeTooLargeForFloatsHasNone) {
  TestMesh huge = soup();
  for (geometry::Vec3f& v : huge.vertices) v = v * 0x1p+70f;
  const GrowingMesh of(huge);
  EXPECT_FALSE(of.tree->makes_blocks());
  kdtree::BuildCounters built;
  of.tree->expand_all(built);
  of.tree->count_steps(~std::uint64_t{0} >> 1);
  EXPECT_FALSE(of.has_top());
}

// As a scene's tree has it: no mesh, leaves below slots.
TEST(CompiledTop, LeadsToTheLeavesOfATreeOfBoxes) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(500, 0.02, 5);
  LazyTree tree(tests::bounds_of(refs), refs.size(), split::default_rule(), source_of(refs));
  kdtree::BuildCounters built;
  tree.expand_all(built);
  const kdtree::EpochPin pin;
  ASSERT_TRUE(tree.entry().is_node());
  std::vector<const kdtree::AtomicSlot*> slots;
  std::set<const wide::WideNode*> nodes;
  list_slots(tree.entry(), slots, nodes);
  std::set<std::uint32_t> ids;
  for (const kdtree::AtomicSlot* slot : slots) {
    const kdtree::Slot now = kdtree::load(*slot);
    ASSERT_TRUE(now.is_leaf());
    EXPECT_GT(now.leaf_count(), 0u);
    std::uint32_t storage;
    for (const std::uint32_t id : tree.tree().leaf(now, storage)) ids.insert(id);
  }
  EXPECT_EQ(ids.size(), refs.size());
}

TEST(CompiledTop, ThreadsThatCompileAndGrowAgree) {
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
        of.tree->count_steps(of.steps_to_top());
        for (std::size_t lane = 0; lane < part.size(); ++lane) {
          if (!(asked.answer(lane) == search(of.mesh, part[lane], {}))) ++wrong;
        }
      }
    };
    std::thread other(ask_all, true);
    ask_all(false);
    other.join();
    EXPECT_EQ(wrong, 0u);
    EXPECT_TRUE(of.entry().is_node());
  }
  kdtree::reclaim();
}

}  // namespace
}  // namespace sightline::accel::lazy
