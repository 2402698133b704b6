// Open edges, solids that leak, flat nodes.
#include "client/importer/self_check.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/closedness.h"
#include "client/importer/ifc_contents.h"
#include "client/importer/scene_from_file.h"

namespace sightline::client::importer {
namespace {

/// A box of six polygons; some may be left out. Each has its own vertices.
FileMesh box(std::size_t sides, double size = 1) {
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  FileMesh mesh;
  mesh.name = "box";
  for (std::size_t s = 0; s < sides; ++s) {
    for (const std::uint32_t k : kSides[s]) {
      mesh.faces.corners.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back({size * ((k & 4U) / 4U), size * ((k & 2U) / 2U), size * (k & 1U)});
    }
    mesh.faces.first.push_back(static_cast<std::uint32_t>(mesh.faces.corners.size()));
  }
  return mesh;
}

FileScene file_with(std::vector<FileMesh> meshes) {
  FileScene scene;
  scene.nodes.emplace_back().name = "root";
  for (std::uint32_t i = 0; i < meshes.size(); ++i)
    scene.nodes.push_back({.name = "part" + std::to_string(i), .parent = 0, .meshes = {i}});
  scene.meshes = std::move(meshes);
  return scene;
}

std::vector<Warning> warnings_of(FileScene file) {
  const auto scene = scene_from_file(std::move(file), {});
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? scene->scene.warnings : std::vector<Warning>{};
}

TEST(SelfCheck, AClosedBoxHasNothingToTell) {
  FileMesh solid = box(6);
  solid.is_solid = true;
  EXPECT_TRUE(warnings_of(file_with({box(6), solid})).empty());
}

TEST(SelfCheck, OpenEdgesAreANote) {
  const auto warnings = warnings_of(file_with({box(6), box(5), box(4)}));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].kind, "open_edges");
  EXPECT_EQ(warnings[0].count, 4U + 8U);
  EXPECT_TRUE(warnings[0].is_note);
  EXPECT_NE(warnings[0].first.find("face"), std::string::npos);
}

TEST(SelfCheck, APartOfSeveralMeshesIsClosedAsAWhole) {
  FileScene scene = file_with({box(5)});
  FileMesh lid = box(6);
  lid.faces.corners.erase(lid.faces.corners.begin(), lid.faces.corners.begin() + 20);
  lid.faces.first = {0, 4};
  scene.meshes.push_back(lid);
  scene.nodes[1].meshes = {0, 1};
  EXPECT_TRUE(warnings_of(scene).empty());
}

TEST(SelfCheck, ASolidThatLeaksIsAWarning) {
  std::vector<FileMesh> meshes{box(6), box(5), box(4, 1e-4), box(3, 1e5)};
  for (FileMesh& mesh : meshes) mesh.is_solid = true;
  const auto warnings = warnings_of(file_with(std::move(meshes)));
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_EQ(warnings[0].kind, "solid_not_closed");
  EXPECT_FALSE(warnings[0].is_note);
  EXPECT_EQ(warnings[0].count, 3U);
  EXPECT_EQ(warnings[0].first, "node 'part1'");
}

// A side cut in two meets its neighbors in one vertex more than they have.
TEST(SelfCheck, AVertexOnAnEdgeIsNoLeak) {
  FileMesh mesh = box(5);
  mesh.is_solid = true;
  for (const Point& p : {Point{0, 0, 1}, Point{1, 0, 1}, Point{1, 0.5, 1}, Point{0, 0.5, 1},
                         Point{0, 0.5, 1}, Point{1, 0.5, 1}, Point{1, 1, 1}, Point{0, 1, 1}}) {
    mesh.faces.corners.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(p);
    if (mesh.vertices.size() % 4 == 0)
      mesh.faces.first.push_back(static_cast<std::uint32_t>(mesh.faces.corners.size()));
  }
  const auto warnings = warnings_of(file_with({mesh}));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].kind, "open_edges");
}

TEST(SelfCheck, FlatNodesAreAWarning) {
  FileScene scene = file_with({box(6), box(6), box(6), box(6)});
  scene.nodes[1].parent_from_local[0] = 0;
  scene.nodes[2].parent_from_local = {1, 2, 0, 0, 2, 4, 0, 0, 0, 0, 1, 0};
  scene.nodes[3].parent_from_local = {1e-30, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e30, 0};
  const auto warnings = warnings_of(scene);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].kind, "flat_node");
  EXPECT_EQ(warnings[0].count, 3U);
  EXPECT_EQ(warnings[0].first, "node 'part0'");
}

TEST(SelfCheck, PolygonsThatCrossThemselvesAreAWarning) {
  FileMesh mesh;
  mesh.name = "bow";
  mesh.vertices = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.corners = {0, 1, 2, 0, 1, 2, 3};
  mesh.faces.first = {0, 3, 7};
  const auto warnings = warnings_of(file_with({mesh}));
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings[0].kind, "polygon_crosses_itself");
  EXPECT_EQ(warnings[0].count, 1U);
  EXPECT_EQ(warnings[0].first, "mesh 0 'bow', face 1");
}

TEST(IfcContents, SolidsAreTheProductsWithABodyOfSolids) {
  const std::string step = R"(ISO-10303-21;
DATA;
#1=IFCEXTRUDEDAREASOLID(#9,#9,#9,3.);
#2=IFCFACEBASEDSURFACEMODEL((#9));
#3= IFCSHAPEREPRESENTATION(#9,'Body','SweptSolid',(#1));
#4=IFCSHAPEREPRESENTATION(#9,'Body','SurfaceModel',(#1,#2));
#5=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
#6=IFCPRODUCTDEFINITIONSHAPE($,$,(#4));
#7=IFCREPRESENTATIONMAP(#9,#3);
#8=IFCMAPPEDITEM(#7,#9);
#10=IFCSHAPEREPRESENTATION(#9,'Body','MappedRepresentation',(#8));
#11=IFCSHAPEREPRESENTATION(#9,'Axis','Curve2D',(#9));
#12=IFCPRODUCTDEFINITIONSHAPE($,$,(#11,#10));
#13=IFCCLOSEDSHELL((#9));
#14=IFCSHELLBASEDSURFACEMODEL((#13));
#15=IFCSHAPEREPRESENTATION(#9,'Body','SurfaceModel',(#14));
#16=IFCPRODUCTDEFINITIONSHAPE($,$,(#15));
#20=IFCWALL('0000000000000000000001',#9,'a, (b;',$,$,#9,#5,$);
#21=IFCWALL('0000000000000000000002',#9,'it''s',$,$,#9,#6,$);
#22=IFCDOOR('0000000000000000000003',#9,$,$,$,#9,#12,$);
#23=IFCSLAB('0000000000000000000004',#9,$,$,$,#9,#16,$);
#24=IFCSITE('0000000000000000000005',#9,$,$,$,#9,$,$);
ENDSEC;
END-ISO-10303-21;
)";
  const auto solids = ifc_contents(Statements(step)).solids;
  EXPECT_EQ(solids.size(), 3U);
  for (const char* const id :
       {"0000000000000000000001", "0000000000000000000003", "0000000000000000000004"})
    EXPECT_TRUE(solids.contains(id)) << id;
}

std::string faces_of(const std::vector<double>& widths) {
  std::string step, bounds;
  int number = 1;
  for (const double w : widths) {
    std::string points;
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {w, 0.0}, {w, w}, {0.0, w}}) {
      step += fmt::format("#{}=IFCCARTESIANPOINT(({:E},{:E},0.));\n", number, x, y);
      points += fmt::format("{}#{}", points.empty() ? "" : ",", number++);
    }
    step += fmt::format("#{}=IFCPOLYLOOP(({}));\n", number, points);
    step += fmt::format("#{}=IFCFACEBOUND(#{},.T.);\n", number + 1, number);
    bounds += fmt::format("{}#{}", bounds.empty() ? "" : ",", number + 1);
    number += 2;
  }
  return step + fmt::format("#1000=IFCFACE(({}));\n", bounds);
}

TEST(IfcContents, FacesAndHolesTooSmallForAssimpAreLost) {
  for (const auto& widths : {std::vector{1.0}, {3e-3}, {1.0, 0.5}, {1.0, 0.05}, {0.0}, {1.0, 0.0}})
    EXPECT_EQ(ifc_contents(Statements(faces_of(widths))).lost_faces, 0U) << widths.front();
  for (const auto& widths : {std::vector{2e-3}, {1e-6}, {1.0, 0.03}, {2e-3, 1e-3}}) {
    EXPECT_EQ(ifc_contents(Statements(faces_of(widths))).lost_faces, 1U) << widths.front();
    EXPECT_EQ(ifc_contents(Statements(faces_of(widths))).first_lost, 1000U);
  }
}

TEST(IfcContents, CornersThatAssimpMergesAreCounted) {
  const std::string shell = "#2000=IFCCLOSEDSHELL((#1000));\n";
  EXPECT_EQ(ifc_contents(Statements(faces_of({1.0, 0.5}) + shell)).merged_corners, 0U);
  EXPECT_EQ(ifc_contents(Statements(faces_of({1.0, 0.0}) + shell)).merged_corners, 0U) << "equal";
  for (const auto& widths : {std::vector{1e5, 1.0}, {1e10, 2.0}, {3.0, 1e-5}}) {
    const IfcContents found = ifc_contents(Statements(faces_of(widths) + shell));
    EXPECT_EQ(found.merged_corners, 4U) << widths.front();
    EXPECT_EQ(found.first_merged, 2000U);
  }
}

TEST(IfcContents, LooseEndsAreCounted) {
  const std::string whole = "#1=IFCA('#9',$);\n#2=IFCB((#1,#1),#3);\n#3=IFCA($,$);\n";
  EXPECT_EQ(ifc_contents(Statements(whole)).loose_ends, 0U);
  const IfcContents loose = ifc_contents(Statements(whole + "#3=IFCA($,$);\n#4=IFCB(#3,#7);\n"));
  EXPECT_EQ(loose.loose_ends, 2U);
  EXPECT_EQ(loose.first_loose, 3U);
}

}  // namespace
}  // namespace sightline::client::importer
