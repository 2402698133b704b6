// Building before rays: the selection of nodes, and the progress.
#include "scenegraph/query/build.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using tests::mesh_of;
using tests::put_node;

/// Node 1 has children 2 (a cube) and 3 (a group with node 4, the same cube); 5 is a separate
/// staircase, 6 a mesh without triangles.
std::shared_ptr<const revision::Snapshot> cubes_and_staircase() {
  const auto cube = mesh_of(tests::cube());
  Scene scene;
  EXPECT_TRUE(
      scene.apply({put_node(-1, 0, nullptr), put_node(-2, -1, cube), put_node(-3, -1, nullptr),
                   put_node(-4, -3, cube), put_node(-5, 0, mesh_of(tests::staircase(3))),
                   put_node(-6, 0, mesh_of({}))}));
  return scene.snapshot();
}

using Ids = std::vector<model::NodeId>;

Ids ids_under(const Ids& roots, const Ids& excluded) {
  const auto snapshot = cubes_and_staircase();
  const auto nodes = mesh_nodes_under(*snapshot, roots, excluded);
  EXPECT_TRUE(nodes);
  Ids ids;
  for (const model::Node* node : *nodes) ids.push_back(node->id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

TEST(Build, SelectsEachNodeOnce) {
  EXPECT_EQ(ids_under({}, {}), (Ids{2, 4, 5}));
  EXPECT_EQ(ids_under({1}, {}), (Ids{2, 4}));
  EXPECT_EQ(ids_under({3, 1, 3, 4}, {}), (Ids{2, 4})) << "roots under roots";
  EXPECT_EQ(ids_under({4, 5}, {}), (Ids{4, 5}));
  EXPECT_EQ(ids_under({}, {3}), (Ids{2, 5}));
  EXPECT_EQ(ids_under({4, 5}, {1}), (Ids{5})) << "a root under an excluded node";
  EXPECT_EQ(ids_under({3}, {3}), Ids{});
  EXPECT_EQ(ids_under({6}, {}), Ids{});
}

TEST(Build, NamesAnUnknownNode) {
  const auto snapshot = cubes_and_staircase();
  const auto root = mesh_nodes_under(*snapshot, Ids{1, 77}, {});
  ASSERT_FALSE(root);
  EXPECT_EQ(root.error().code, Code::kNotFound);
  EXPECT_EQ(root.error().message, "root node 77 is not in revision 1");
  EXPECT_EQ(mesh_nodes_under(*snapshot, {}, Ids{78}).error().message,
            "excluded node 78 is not in revision 1");
}

TEST(Build, BuildsOnlyTheSelection) {
  const auto snapshot = cubes_and_staircase();
  BuildProgress progress;
  const auto nodes = mesh_nodes_under(*snapshot, Ids{1}, {});
  EXPECT_EQ(meshes_of(*nodes).size(), 1u);
  ASSERT_TRUE(build_mesh_trees(*nodes, progress, nullptr));
  EXPECT_EQ(progress.meshes_done, 1u);
  EXPECT_EQ(progress.meshes_total, 1u);
  EXPECT_EQ(progress.triangles_done, 12u);
  const revision::BuildSummary built = summarize_build(*snapshot);
  EXPECT_EQ(built.triangles_built, 12u);
  EXPECT_EQ(built.instances_entered, 2u);
}

TEST(Build, CountsTheTrianglesOfMeshesThatAreBegun) {
  const tests::TestMesh soup = tests::random_soup(20'000, 0.02, 5);
  Scene scene;
  ASSERT_TRUE(
      scene.apply({put_node(-1, 0, mesh_of(soup)), put_node(-2, 0, mesh_of(tests::cube()))}));
  const auto snapshot = scene.snapshot();
  const auto nodes = mesh_nodes_under(*snapshot, {}, {});
  const auto meshes = meshes_of(*nodes);
  EXPECT_EQ(triangles_begun(meshes), 0u) << "nothing is";
  std::uint64_t before = 0;
  for (const double x : {0.1, 0.4, 0.9}) {
    const accel::geometry::Ray ray{{x, 0.3, -5}, {0, 0, 1}};
    RayTally tally;
    ASSERT_TRUE(count_hits(*snapshot, std::span(&ray, 1), std::span(&tally, 1), TraceOptions{}));
    const std::uint64_t begun = triangles_begun(meshes);
    EXPECT_GT(begun, before);
    EXPECT_LT(begun, 20'000u);
    before = begun;
  }
  BuildProgress progress;
  ASSERT_TRUE(build_mesh_trees(*nodes, progress, nullptr));
  EXPECT_EQ(triangles_begun(meshes), 0u) << "all are complete";
  EXPECT_EQ(progress.triangles_done, 20'012u);
}

TEST(Build, CountsMeshesAndCells) {
  const tests::TestMesh sheet = tests::planar_sheet(100);
  Scene scene;
  ASSERT_TRUE(scene.apply({put_node(-1, 0, mesh_of(sheet))}));
  const auto snapshot = scene.snapshot();
  const auto nodes = mesh_nodes_under(*snapshot, {}, {});
  BuildProgress progress;
  EXPECT_TRUE(build_mesh_trees(*nodes, progress, nullptr));
  EXPECT_EQ(progress.triangles_done, sheet.faces.size());
  EXPECT_EQ(progress.share(), 1);
  const std::uint64_t mesh_cells = progress.cells_expanded;
  EXPECT_GT(mesh_cells, 0u);
  EXPECT_TRUE(build_scene_tree(*snapshot, progress, nullptr));
  EXPECT_EQ(progress.meshes_done, 1u);
  BuildProgress all;
  const auto again = build_all(*snapshot, nullptr, &all);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->cells_expanded, 0u) << "everything was built before";
  EXPECT_EQ(all.share(), 1);
}

/// A cast with a full build looks at no tree if an earlier one has made them all.
TEST(Build, RemembersThatAllTreesAreComplete) {
  const auto snapshot = cubes_and_staircase();
  EXPECT_FALSE(snapshot->is_complete());
  BuildProgress part;
  ASSERT_TRUE(build_mesh_trees(*mesh_nodes_under(*snapshot, {}, {}), part, nullptr));
  EXPECT_FALSE(snapshot->is_complete()) << "the scene's own trees are left";
  for (const model::Mesh* mesh : snapshot->meshes())
    EXPECT_EQ(mesh->tree().is_complete(), mesh->triangles() > 0)
        << "an empty mesh was not selected";
  ASSERT_TRUE(build_all(*snapshot));
  EXPECT_TRUE(snapshot->is_complete());
  BuildProgress again;
  const auto stats = build_all(*snapshot, nullptr, &again);
  ASSERT_TRUE(stats);
  EXPECT_EQ(stats->touches, 0u);
  EXPECT_EQ(again.meshes_done, again.meshes_total) << "reported also of trees that were complete";
}

TEST(Build, ACancelledBuildStops) {
  const auto snapshot = cubes_and_staircase();
  const auto nodes = mesh_nodes_under(*snapshot, {}, {});
  BuildProgress progress;
  const std::atomic<bool> cancelled{true};
  EXPECT_EQ(build_mesh_trees(*nodes, progress, &cancelled).error().code, Code::kCancelled);
  EXPECT_EQ(build_scene_tree(*snapshot, progress, &cancelled).error().code, Code::kCancelled);
  const std::vector<accel::geometry::Ray> rays = tests::rays_at(tests::cube(), 10, 1);
  EXPECT_EQ(grow_for_rays(*snapshot, rays, {.cancelled = &cancelled}, progress).error().code,
            Code::kCancelled);
  EXPECT_EQ(progress.meshes_done, 0u);
  EXPECT_EQ(progress.rays_done, 0u);
  EXPECT_EQ(summarize_build(*snapshot).triangles_built, 0u);
}

TEST(Build, GrowsForRaysTheCellsThatACastWouldGrow) {
  const std::vector<accel::geometry::Ray> rays = tests::rays_at(tests::cube(), 10'000, 1);
  for (const QueryKind kind : {QueryKind::kClosest, QueryKind::kAny, QueryKind::kCount}) {
    const auto snapshot = cubes_and_staircase();
    BuildProgress progress;
    ASSERT_TRUE(grow_for_rays(*snapshot, rays, {.kind = kind}, progress));
    EXPECT_EQ(progress.rays_done, rays.size());
    EXPECT_GT(progress.cells_expanded, 0u);
    BuildProgress again;
    ASSERT_TRUE(grow_for_rays(*snapshot, rays, {.kind = kind}, again));
    EXPECT_EQ(again.cells_expanded, 0u);
  }
}

}  // namespace
}  // namespace sightline::scenegraph::query
