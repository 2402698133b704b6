// The cells that rays have not built yet.
#include "scenegraph/revision/deferred_cells.h"

#include <gtest/gtest.h>

#include "scenegraph/query/build.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::revision {
namespace {

/// Two balls, 20 apart, of one mesh.
void add_balls(Scene& scene) {
  const tests::TestMesh ball = tests::icosphere(5);
  const auto mesh = *model::Mesh::make(ball.vertices, ball.faces);
  std::vector<model::Update> updates;
  for (int i = 0; i < 2; ++i) {
    model::PutNode put;
    put.node = -1 - i;
    put.mesh = mesh;
    put.parent_from_local.m[3] = 20 * i;
    updates.emplace_back(put);
  }
  ASSERT_TRUE(scene.apply(updates));
}

double half_area(const std::array<float, 6>& b) {
  const double x = b[3] - b[0], y = b[4] - b[1], z = b[5] - b[2];
  return x * y + y * z + z * x;
}

TEST(DeferredCellsTest, AreWholeMeshesBeforeTheFirstRay) {
  Scene scene;
  add_balls(scene);
  const DeferredCells cells = deferred_cells(*scene.snapshot(), 100);
  EXPECT_EQ(cells.total, 2u);
  ASSERT_EQ(cells.boxes.size(), 2u);
  for (const auto& box : cells.boxes) EXPECT_NEAR(box[3] - box[0], 2, 0.1);
}

TEST(DeferredCellsTest, ShrinkWhereRaysGoAndVanishWhenAllIsBuilt) {
  Scene scene;
  add_balls(scene);
  std::vector<accel::geometry::Hit> hits(1);
  ASSERT_TRUE(trace(*scene.snapshot(), {{{{0.1, 0.2, 9}, {0, 0, -1}}}}, hits, {}));
  const DeferredCells cells = deferred_cells(*scene.snapshot(), 100'000);
  EXPECT_GT(cells.total, 2u);
  ASSERT_EQ(cells.boxes.size(), cells.total);
  for (std::size_t i = 1; i < cells.boxes.size(); ++i)
    EXPECT_GE(half_area(cells.boxes[i - 1]) * (1 + 1e-5), half_area(cells.boxes[i]));
  const DeferredCells few = deferred_cells(*scene.snapshot(), 3);
  EXPECT_EQ(few.total, cells.total);
  ASSERT_EQ(few.boxes.size(), 3u);
  EXPECT_EQ(few.boxes[0], cells.boxes[0]);
  ASSERT_TRUE(query::build_all(*scene.snapshot()));
  EXPECT_EQ(deferred_cells(*scene.snapshot(), 100).total, 0u);
}

TEST(DeferredCellsTest, AnEmptySceneHasNone) {
  Scene scene;
  EXPECT_EQ(deferred_cells(*scene.snapshot(), 100).total, 0u);
}

}  // namespace
}  // namespace sightline::scenegraph::revision
