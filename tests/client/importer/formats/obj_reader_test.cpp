// OBJ files as they are found: marks, ends of lines, corners, groups, and what is refused.
#include "client/importer/formats/obj_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/client/importer/formats/read_bytes.h"

namespace sightline::client::importer::formats {
namespace {

using Corners = std::vector<std::uint32_t>;

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

Result<FileScene> obj(const std::string& text) { return read_bytes(read_obj, text, "a.obj"); }

// The corners of the only mesh.
Corners corners_of(const std::string& text) {
  const auto scene = obj(text);
  EXPECT_TRUE(scene) << error_of(scene) << " in " << text;
  if (!scene || scene->meshes.size() != 1) return {};
  return scene->meshes[0].faces.corners;
}

std::string refusal(const std::string& statements) { return error_of(obj(kSquare + statements)); }

std::string warnings(const std::string& text) {
  const auto scene = obj(text);
  return scene ? kinds_of(*scene) : scene.error().message;
}

TEST(ObjReader, SkipsAByteOrderMark) {
  const std::string mark = "\xef\xbb\xbf";
  EXPECT_EQ(corners_of(mark + kSquare + "f 1 2 3\n"), (Corners{0, 1, 2}));
  EXPECT_EQ(corners_of(mark + "# a comment\n" + kSquare + "f 1 2 3\n"), (Corners{0, 1, 2}));
  EXPECT_EQ(corners_of(mark + "\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n"),
            (Corners{0, 1, 2}));
}

TEST(ObjReader, LinesEndInAnyWay) {
  const std::vector<std::string> lines{"v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3", ""};
  for (const char* end : {"\n", "\r", "\r\n", " \t\n", " # end\n", "\n\n"}) {
    std::string text;
    for (const std::string& line : lines) text += line + end;
    EXPECT_EQ(corners_of(text), (Corners{0, 1, 2})) << end;
    EXPECT_EQ(warnings(text), "") << end;
  }
}

TEST(ObjReader, ABackslashContinuesALine) {
  EXPECT_EQ(corners_of(std::string(kSquare) + "f 1 2 \\\n3 4\n"), (Corners{0, 1, 2, 3}));
  EXPECT_EQ(corners_of(std::string(kSquare) + "f \\\r\n1\\\r\n2\\\r\n 3\r\n"), (Corners{0, 1, 2}));
  EXPECT_EQ(corners_of("v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), (Corners{0, 1, 2}));
  EXPECT_TRUE(holds(refusal("f 1 \\\n2 \\\n 9\n"), "line 5: "));
  EXPECT_TRUE(holds(refusal("f 1 \\\n2 3\nf 1 2 0\n"), "line 7: "));
}

TEST(ObjReader, CornersHaveAnyForm) {
  for (const char* face : {"f 1 2 3", "f 1/ 2/ 3/", "f 1/1/ 2/2/ 3/3/", "f 1//1 2//2 3//3",
                           "f 1// 2// 3//", "f 1/7/9 2/7/9 3/7/9", "f\t1\t2\t3", "  f   1  2   3  ",
                           "f -4 -3 -2", "f -4/-1/-1 -3 3", "f +1 +2 +3"}) {
    EXPECT_EQ(corners_of(std::string(kSquare) + face + "\n"), (Corners{0, 1, 2})) << face;
  }
  EXPECT_EQ(corners_of(std::string(kSquare) + "f 1 2 3 4\n"), (Corners{0, 1, 2, 3}));
}

TEST(ObjReader, NegativeCornersCountFromTheirLine) {
  EXPECT_EQ(corners_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -1 -2 -3\n"),
            (Corners{0, 1, 2, 3, 2, 1}));
}

TEST(ObjReader, FacesMayComeBeforeTheirVertices) {
  EXPECT_EQ(corners_of(std::string("f 1 2 3\n") + kSquare + "f 2 3 4\n"),
            (Corners{0, 1, 2, 1, 2, 3}));
  EXPECT_EQ(error_of(obj(std::string("f 1 2 3\nf 2 3 5\n") + kSquare)),
            "line 2: a face names vertex 5, but there are 4");
}

TEST(ObjReader, MissingVerticesAreRefused) {
  EXPECT_EQ(refusal("f 1 2 5\n"), "line 5: a face names vertex 5, but there are 4");
  EXPECT_EQ(refusal("f 1 2 0\n"), "line 5: a face names vertex 0, but the first one is 1");
  EXPECT_EQ(refusal("\nl -5 1\n"), "line 6: a face names vertex -5, but there are 4");
  EXPECT_TRUE(holds(refusal("f 1 2 99999999999\n"), "names vertex 99999999999"));
  EXPECT_TRUE(holds(refusal("f 1 2 99999999999999999999\n"), "is no corner"));
}

TEST(ObjReader, WordsThatAreNoNumberAreRefused) {
  EXPECT_TRUE(holds(error_of(obj("v 0 0\n")), "line 1: a vertex has 2 numbers"));
  EXPECT_TRUE(holds(error_of(obj("v 0 0 x\n")), "line 1: 'x' is no number"));
  EXPECT_TRUE(holds(error_of(obj("\nv 1,5 0 0\n")), "line 2: '1,5' is no number; the decimal"));
  EXPECT_TRUE(holds(error_of(obj("v 1, 2, 3\n")), "'1,' is no number"));
  EXPECT_TRUE(holds(error_of(obj("v 0x10 0 0\n")), "'0x10'"));
  for (const char* face : {"f 1 2 a\n", "f 1 2 3.5\n", "f 1 2 3/a\n", "f 1 2 /3\n", "f 1;2;3\n"})
    EXPECT_TRUE(holds(refusal(face), "is no corner of a face")) << face;
}

TEST(ObjReader, PositionsAreTheNearestDoubles) {
  const auto scene =
      obj("v 388096.37 3948996.813 -1e-3\nv +1. .5 1E+2\nv 1e999 -1e999 1e-999\nv nan -inf 1.#INF\n"
          "f 1 2 3 4\n");
  ASSERT_TRUE(scene) << error_of(scene);
  const std::vector<Point>& v = scene->meshes.at(0).vertices;
  EXPECT_EQ(v[0], (Point{388096.37, 3948996.813, -1e-3}));
  EXPECT_EQ(v[1], (Point{1, 0.5, 100}));
  EXPECT_EQ(v[2], (Point{INFINITY, -INFINITY, 0}));
  EXPECT_TRUE(std::isnan(v[3][0]));
  EXPECT_EQ(v[3][1], -INFINITY);
  EXPECT_EQ(v[3][2], INFINITY);
}

TEST(ObjReader, ColorsAndWeightsAreNoPositions) {
  const auto scene = obj("v 1 2 3 0.5 0.5 0.5\nv 4 5 6 1\nv 7 8 9 2\nv 1 1 1 1 1 1 1\nf 1 2 3 4\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.at(0).vertices,
            (std::vector<Point>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 1, 1}}));
  ASSERT_EQ(kinds_of(*scene), "vertex_weights ");
  EXPECT_EQ(scene->warnings[0].count, 1U);
  EXPECT_EQ(scene->warnings[0].first, "line 3");
}

TEST(ObjReader, AWeightOtherThanOneIsAWarning) {
  const std::string rest = std::string(kSquare) + "f 1 2 3\n";
  for (const char* weight : {"0", "0.5", "2", "-1", "1e-3", "0.9999999", "nan", "inf"})
    EXPECT_EQ(warnings("v 7 8 9 " + std::string(weight) + "\n" + rest), "vertex_weights ")
        << weight;
  for (const char* more : {"1", "1.0", "1e0", "+1", "0.2 0.3 0.4", "0.2 0.3 0.4 0.5", "1 0 0 0"})
    EXPECT_EQ(warnings("v 7 8 9 " + std::string(more) + "\n" + rest), "") << more;
  const auto scene = obj("v 7 8 9 4\nv 1 0 0 0.25\nv 0 1 0\nv 2 2 2 1\nv 4 4 4 0\nf 1 2 3\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.at(0).vertices.at(0), (Point{7, 8, 9})) << "not divided";
  EXPECT_EQ(scene->warnings.at(0).count, 3U);
}

// Two lines that a backslash or a lost line end made one would take a vertex away.
TEST(ObjReader, WordsAfterAPositionAreNumbers) {
  EXPECT_EQ(refusal("v 0 0 0 v 1 1 1\n"), "line 5: 'v' is no number");
  EXPECT_EQ(refusal("v 0 0 0\\\nv 1 1 1\n"), "line 5: 'v' is no number");
  EXPECT_EQ(refusal("v 0 0 0 0.5 red\n"), "line 5: 'red' is no number");
  EXPECT_EQ(refusal("v 0 0 0 # red\n"), "");
}

TEST(ObjReader, ACommentEndsWithItsLine) {
  for (const char* comment : {"# from C:\\models\\\n", "#\\\n", "  # a\\\r\n", "\t#b \\\n"}) {
    EXPECT_EQ(corners_of(comment + std::string(kSquare) + "f 1 2 3\n"), (Corners{0, 1, 2}));
    EXPECT_EQ(corners_of(std::string(kSquare) + "f 1 2 3\n" + comment + "f 2 3 4\n"),
              (Corners{0, 1, 2, 1, 2, 3}));
  }
  EXPECT_EQ(warnings(std::string(kSquare) + "f 1 2 3\n# one \\\n two\n"), "unknown_statements ");
}

TEST(ObjReader, LinesAndPointsAreFacesOfFewCorners) {
  const auto scene = obj(std::string(kSquare) + "l 1 2 3\np 4 1\nf 1 2\nf 1 2 3\n");
  ASSERT_TRUE(scene) << error_of(scene);
  const Polygons& faces = scene->meshes.at(0).faces;
  EXPECT_EQ(faces.first, (Corners{0, 2, 4, 5, 6, 8, 11}));
  EXPECT_EQ(faces.corners, (Corners{0, 1, 1, 2, 3, 0, 0, 1, 0, 1, 2}));
}

// A node for each line, with its meshes as NAME(faces).
std::string outline(const std::string& statements) {
  const auto scene = obj(kSquare + statements);
  if (!scene) return scene.error().message;
  std::string out;
  for (const FileNode& node : scene->nodes) {
    out += node.name + ":";
    for (const std::uint32_t m : node.meshes) {
      const FileMesh& mesh = scene->meshes[m];
      out += " " + mesh.name + "(" + std::to_string(mesh.faces.size()) + ")";
    }
    out += "\n";
  }
  return out;
}

TEST(ObjReader, ObjectsGroupsAndMaterialsAreNodesAndMeshes) {
  const std::string f = "f 1 2 3\n";
  EXPECT_EQ(outline(f), "a.obj:\ndefaultobject: defaultobject(1)\n");
  EXPECT_EQ(outline("g a b\n" + f + "g\n" + f + "g a b\n" + f),
            "a.obj:\na b: a b(1)\n: (1)\na b: a b(1)\n");
  EXPECT_EQ(outline("g a\n" + f + "g a\n" + f), "a.obj:\na: a(2)\n");
  EXPECT_EQ(outline("usemtl m\n" + f + "usemtl n\n" + f + "usemtl n\n" + f),
            "a.obj:\ndefaultobject: defaultobject(1) n(2)\n");
  EXPECT_EQ(outline("o x\nusemtl m\n" + f + "o y\n" + f + "usemtl n\n" + f + "usemtl m\n" + f),
            "a.obj:\nx: x(1)\ny: y(1) n(1) m(1)\n");
  EXPECT_EQ(outline("o empty\no x\n" + f), "a.obj:\nempty:\nx: x(1)\n");
  EXPECT_EQ(outline(f + "usemtl n\n" + f), "a.obj:\ndefaultobject: defaultobject(2)\n");
}

TEST(ObjReader, AnObjectGoesOnUnderItsName) {
  const std::string f = "f 1 2 3\n";
  EXPECT_EQ(outline("o wall 1\n" + f + "o wall 2\n" + f + "o wall 1\n" + f),
            "a.obj:\nwall 1: wall 1(2)\nwall 2: wall 2(1)\n");
  EXPECT_EQ(outline("o a\nusemtl m\n" + f + "o b\nusemtl n\n" + f + "o a\n" + f),
            "a.obj:\na: a(1) n(1)\nb: b(1)\n");
}

TEST(ObjReader, MeshesHaveTheirVerticesInTheOrderOfTheFile) {
  const auto scene = obj(std::string(kSquare) + "o a\nf 4 3 2\no b\nf 3 1 2\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.at(0).vertices, (std::vector<Point>{{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(scene->meshes.at(0).faces.corners, (Corners{2, 1, 0}));
  EXPECT_EQ(scene->meshes.at(1).faces.corners, (Corners{2, 0, 1}));
}

TEST(ObjReader, AFileWithoutFacesIsACloud) {
  for (const char* end : {"", "o cloud\n", "vn 0 0 1\n"}) {
    const auto scene = obj(std::string(kSquare) + end);
    ASSERT_TRUE(scene) << error_of(scene);
    ASSERT_EQ(scene->meshes.size(), 1U);
    EXPECT_EQ(scene->meshes[0].vertices.size(), 4U);
    EXPECT_EQ(scene->nodes[0].meshes, (Corners{0}));
  }
}

TEST(ObjReader, WhatIsNotReadIsCounted) {
  const std::string f = std::string(kSquare) + "f 1 2 3\n";
  EXPECT_EQ(warnings(f + "mtllib a.mtl\nusemtl b\ns off\nvt 0 0\nvn 0 0 1\nvp 1 2\nlod 3\n"), "");
  const auto curves = obj(f + "cstype bspline\ndeg 3\ncurv 0 1 1 2 3\nparm u 0 1\nend\nsurf 0 1\n");
  ASSERT_TRUE(curves) << error_of(curves);
  ASSERT_EQ(kinds_of(*curves), "curves_and_surfaces ");
  EXPECT_EQ(curves->warnings[0].count, 2U);
  EXPECT_EQ(curves->warnings[0].first, "line 8: curv");
  EXPECT_EQ(warnings(f + "call other.obj\n"), "calls ");
  EXPECT_EQ(warnings(f + "csh rm -r x\n"), "calls ");
  EXPECT_EQ(warnings(f + "bogus 1 2\nbogus\n"), "unknown_statements ");
  EXPECT_EQ(warnings(f + "f\n"), "empty_faces ");
}

TEST(ObjReader, EachStatementThatAddsASurfaceIsNamed) {
  const std::string f = std::string(kSquare) + "f 1 2 3\n";
  for (const char* curve : {"curv 0 1 1 2 3 4", "curv2 1 2 3", "surf 0 1 0 1 1 2 3 4",
                            "cdc 1 2 3 4", "cdp 1 2 3 4", "bzp 1 2 3 4", "bsp 1 2 3 4"}) {
    const auto scene = obj(f + "\n" + curve + "\nend\n");
    ASSERT_TRUE(scene) << error_of(scene);
    ASSERT_EQ(kinds_of(*scene), "curves_and_surfaces ") << curve;
    const std::string word(curve, std::string_view(curve).find(' '));
    EXPECT_EQ(scene->warnings[0].first, "line 7: " + word);
  }
  for (const char* call : {"call part.obj 1", "csh -ls", "csh ls"})
    EXPECT_EQ(warnings(f + call + "\n"), "calls ") << call;
  for (const char* unknown : {"fo 1 2 3", "F 1 2 3", "V 0 0 0", "vertex 0 0 0", "xyz", "3 4"})
    EXPECT_EQ(warnings(f + unknown + "\n"), "unknown_statements ") << unknown;
}

TEST(ObjReader, TheLastStatementIsWhole) {
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* end : {"f 1 2 3\n", "f 1 2 3\r\n", "f 1 2 3\n# the end", "f 1 2 3\n  \n"})
    EXPECT_EQ(warnings(start + end), "") << end;
  for (const char* end : {"f 1 2 3", "v 0 0 1", "f 1/1/1 2/2/2 3//3", "usemtl a", "f -1 -2 -3",
                          "f 1/ 2/ 3/", "f 1// 2// 3//", "l 1 2", "f 1 2 3 # end"})
    EXPECT_EQ(warnings(start + end), "cut_off ") << end;
  for (const char* end : {"f 1 2", "f", "v 0 0", "v 0 0 1e", "v 0 0 -", "f 1 2 3/", "f 1 2 -",
                          "f 1/1/1 2/2/2 3/3/", "f 1/1/1 2/2/2 3/3", "l 1", "vn 0 0"})
    EXPECT_TRUE(holds(error_of(obj(start + end)), "cut off: its last line is no whole")) << end;
}

}  // namespace
}  // namespace sightline::client::importer::formats
