// Up axes and units.
#include "client/importer/frame.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

namespace sightline::client::importer {
namespace {

using Rows = std::array<double, 12>;

ImportedScene scene_of(UpAxis up, double unit) {
  ImportedScene scene;
  scene.up_axis = up;
  scene.meters_per_unit = unit;
  ImportedNode root;
  root.parent_from_local = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  ImportedNode child = root;
  child.parent = 0;
  scene.nodes = {root, child};
  return scene;
}

TEST(Frame, ZUpMapsYToZ) {
  ImportedScene scene = scene_of(UpAxis::kY, 1);
  convert_frame(scene, UpAxis::kZ, {});
  EXPECT_EQ(scene.nodes[0].parent_from_local, (Rows{1, 2, 3, 4, -9, -10, -11, -12, 5, 6, 7, 8}));
  EXPECT_EQ(scene.nodes[1].parent_from_local, (Rows{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(scene.up_axis, UpAxis::kZ);
}

TEST(Frame, ConvertingBackIsTheIdentity) {
  ImportedScene scene = scene_of(UpAxis::kZ, 1);
  const Rows before = scene.nodes[0].parent_from_local;
  convert_frame(scene, UpAxis::kY, {});
  EXPECT_NE(scene.nodes[0].parent_from_local, before);
  convert_frame(scene, UpAxis::kZ, {});
  EXPECT_EQ(scene.nodes[0].parent_from_local, before);
}

TEST(Frame, AnotherUnitScalesTheRoots) {
  ImportedScene scene = scene_of(UpAxis::kY, 0.5);
  convert_frame(scene, {}, 1.0);
  EXPECT_EQ(scene.nodes[0].parent_from_local,
            (Rows{0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6}));
  EXPECT_EQ(scene.nodes[1].parent_from_local[0], 1);
  EXPECT_EQ(scene.meters_per_unit, 1);
}

TEST(Frame, AFrameThatTheFileDoesNotStateIsOnlyRecorded) {
  ImportedScene scene = scene_of(UpAxis::kUnknown, 0);
  const Rows before = scene.nodes[0].parent_from_local;
  convert_frame(scene, UpAxis::kZ, 0.001);
  EXPECT_EQ(scene.nodes[0].parent_from_local, before);
  EXPECT_EQ(scene.up_axis, UpAxis::kZ);
  EXPECT_EQ(scene.meters_per_unit, 0.001);
}

TEST(Frame, NoRequestChangesNothing) {
  ImportedScene scene = scene_of(UpAxis::kZ, 0.01);
  const Rows before = scene.nodes[0].parent_from_local;
  convert_frame(scene, {}, {});
  EXPECT_EQ(scene.nodes[0].parent_from_local, before);
  EXPECT_EQ(scene.up_axis, UpAxis::kZ);
  EXPECT_EQ(scene.meters_per_unit, 0.01);
}

TEST(TurnedAxes, AreReportedUnlessAnAxisWasAskedFor) {
  const auto collada = [](const char* up, std::optional<UpAxis> asked = {}) {
    return turned_axes("Collada Importer", std::string("<up_axis> ") + up + "\n</up_axis>", asked);
  };
  EXPECT_NE(collada("Z_UP").find("--up z"), std::string::npos);
  EXPECT_EQ(collada("Z_UP", UpAxis::kZ), "");
  EXPECT_EQ(collada("Z_UP", UpAxis::kY), "");
  EXPECT_EQ(collada("Y_UP"), "");
  EXPECT_NE(collada("X_UP").find("(-y, x, z) here, so that y"), std::string::npos);
  EXPECT_NE(collada("X_UP", UpAxis::kZ).find("(-y, -z, x) here, so that z"), std::string::npos);
  EXPECT_EQ(turned_axes("Collada Importer", "<COLLADA/>", {}), "");
  EXPECT_NE(turned_axes("Industry Foundation Classes (IFC) Importer", "", {}), "");
  EXPECT_EQ(turned_axes("Stereolithography (STL) Importer", "<up_axis>Z_UP</up_axis>", {}), "");
}

}  // namespace
}  // namespace sightline::client::importer
