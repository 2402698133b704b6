// STL files in text and in binary: case, names, wrong counts and sizes, and what is refused.
#include "client/importer/formats/stl_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "tests/client/importer/formats/read_bytes.h"

namespace sightline::client::importer::formats {
namespace {

constexpr const char* kFacet =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1.5e0 0\n "
    "endloop\nendfacet\n";

Result<FileScene> stl(const std::string& bytes) { return read_bytes(read_stl, bytes, "a.stl"); }

std::string changed(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string binary(std::uint32_t count, std::size_t facets, std::string head = "made by hand") {
  head.resize(80, ' ');
  std::string bytes = head;
  bytes.append(reinterpret_cast<const char*>(&count), sizeof(count));
  for (std::size_t i = 0; i < facets; ++i) {
    for (const float x : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.5F, 0.F})
      bytes.append(reinterpret_cast<const char*>(&x), sizeof(x));
    bytes += "\x12\xff";
  }
  return bytes;
}

// The numbers of facets of all meshes, with a blank after each; or the error.
std::string facets(const Result<FileScene>& scene) {
  if (!scene) return scene.error().message;
  std::string out;
  for (const FileMesh& mesh : scene->meshes) {
    out += std::to_string(mesh.faces.size()) + " ";
    EXPECT_EQ(mesh.vertices.size(), 3 * mesh.faces.size());
    if (mesh.faces.size() == 0) continue;
    EXPECT_EQ(mesh.vertices[1], (Point{1, 0, 0}));
    EXPECT_EQ(mesh.vertices[2], (Point{0, 1.5, 0}));
  }
  return out;
}

std::string kinds(const std::string& bytes) {
  const auto scene = stl(bytes);
  return scene ? kinds_of(*scene) : scene.error().message;
}

TEST(StlReader, KeywordsAreInAnyCase) {
  const std::string text = "solid part\n" + std::string(kFacet) + kFacet + "endsolid part\n";
  const std::string head = "solid part", Head = "Solid part";
  for (const std::string& t :
       {text, upper(text), changed(text, "solid", "Solid"), changed(text, "facet", "FACET"),
        changed(text, "vertex", "Vertex")}) {
    EXPECT_EQ(facets(stl(t)), "2 ") << t;
    EXPECT_EQ(kinds(t), "") << t;
  }
  EXPECT_EQ(stl(upper(text))->meshes[0].name, "PART");
}

TEST(StlReader, WordsAndLinesArePartedInAnyWay) {
  const std::string text = "solid a\n" + std::string(kFacet) + "endsolid a\n";
  for (const std::string& t :
       {changed(text, "\n", "\r\n"), changed(text, "\n", "\r"), changed(text, "\n", "\n\n\t"),
        "\xef\xbb\xbf" + text, " \n " + text, changed(text, "endfacet", "end facet"),
        changed(text, "endloop", "end loop"), changed(text, "endsolid", "end solid"),
        changed(text, " 0 0 1\n", " nan nan nan\n"), changed(text, "\n", " "),
        changed(text, " a\n", "\n")}) {
    EXPECT_EQ(facets(stl(t)), "1 ") << t;
    EXPECT_EQ(kinds(t), "") << t;
  }
}

TEST(StlReader, EachSolidIsANodeWithItsName) {
  const std::string f = kFacet;
  const auto scene = stl("solid one part\n" + f + "endsolid one part\nsolid two\n" + f + f +
                         "endsolid two\nsolid none\nendsolid\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(facets(scene), "1 2 0 ");
  ASSERT_EQ(scene->nodes.size(), 4U);
  EXPECT_EQ(scene->nodes[1].name, "one part");
  EXPECT_EQ(scene->nodes[2].name, "two");
  EXPECT_EQ(scene->nodes[2].meshes, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(scene->meshes[2].name, "none");
  EXPECT_EQ(scene->nodes[0].name, "");
  EXPECT_EQ(stl("solid\n" + f + "endsolid\n")->nodes[0].name, "<STL_ASCII>");
  EXPECT_EQ(stl("solid a facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1.5 0 "
                "endloop endfacet endsolid a")
                ->meshes[0]
                .name,
            "a");
}

TEST(StlReader, SeveralSolidsMayBeOnOneLine) {
  const std::string f = changed(kFacet, "\n", " ");
  for (const char* end : {"endsolid", "endsolid one", "endsolid one part", "end solid one"}) {
    const auto scene = stl("solid one " + f + end + " solid two parts " + f + f + "endsolid");
    ASSERT_TRUE(scene) << error_of(scene);
    EXPECT_EQ(facets(scene), "1 2 ") << end;
    EXPECT_EQ(scene->meshes[1].name, "two parts") << end;
    EXPECT_EQ(kinds_of(*scene), "") << end;
  }
  EXPECT_EQ(facets(stl("solid a " + f + "endsolid a " + f + "endsolid\n")), "1 1 ");
}

// A name that is looked for up to the end of its line would make this quadratic.
TEST(StlReader, ALineMayBeLong) {
  const std::string solid = "solid a " + changed(kFacet, "\n", " ");
  std::string text;
  for (int i = 0; i < 30'000; ++i) text += solid;
  const auto scene = stl(text + "endsolid\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.size(), 30'000U);
}

TEST(StlReader, AsciiFilesThatAreCutOffAreADoubt) {
  const std::string text = "solid a\n" + std::string(kFacet);
  EXPECT_EQ(kinds(text + "endsolid"), "");
  for (const std::string& end : {std::string(), std::string(kFacet), std::string("facet normal 0"),
                                 std::string(kFacet).substr(0, 60),
                                 std::string("facet normal 0 0 1 "
                                             "outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1.")}) {
    EXPECT_EQ(kinds(text + end), "cut_off ") << end;
    EXPECT_EQ(facets(stl(text + end)), end == kFacet ? "2 " : "1 ") << end;
  }
}

TEST(StlReader, FacetsHaveThreeVertices) {
  const std::string start = "solid a\n", end = "endsolid a\n";
  EXPECT_EQ(error_of(stl(start + changed(kFacet, "  vertex 1 0 0\n", "") + end)),
            "line 2: a facet has 2 vertices, must have 3");
  EXPECT_EQ(
      error_of(stl(start + kFacet +
                   changed(kFacet, "  vertex 1 0 0\n", "vertex 1 0 0\nvertex 1 1 1\n") + end)),
      "line 9: a facet has 4 vertices, must have 3");
  EXPECT_TRUE(holds(error_of(stl(start + "facet normal 0 0 1\n" + kFacet + end)),
                    "line 3: 'facet' before the end of a facet"));
  EXPECT_TRUE(holds(error_of(stl(start + changed(kFacet, "1.5e0", "1,5") + end)),
                    "line 6: '1,5' is no number; the decimal sign"));
  EXPECT_TRUE(holds(error_of(stl(start + changed(kFacet, "1.5e0 0", "1.5e0") + end)),
                    "'endloop' is no number"));
  EXPECT_EQ(kinds(start + "color 1 0 0\n" + kFacet + end), "unknown_statements ");
}

TEST(StlReader, StrayWordsAreADoubt) {
  const std::string start = "solid a\n", end = "endsolid a\n";
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"1 0 0", "1 0 0 0"},
                                                        {"outer loop", "outer loop\nouter loop"},
                                                        {"normal 0 0 1", "normal 0 0 1 1"},
                                                        {"normal 0 0 1", "normal 0 vert"},
                                                        {"\n  vertex 1", "\n# vertex 1"},
                                                        {"\n endloop", "\n endloop\n endloop"},
                                                        {"endloop", "end_loop"}}) {
    const auto scene = stl(start + changed(kFacet, from, to) + end);
    EXPECT_EQ(facets(scene), "1 ") << to;
    ASSERT_TRUE(scene);
    EXPECT_EQ(kinds_of(*scene), "unknown_statements ") << to;
  }
  EXPECT_EQ(kinds(start + changed(kFacet, "0 0 1\n", "nan -inf -1.#IND\n") + end), "");
  for (const char* left_out : {"endloop", "outer loop", "normal 0 0 1"})
    EXPECT_EQ(kinds(start + changed(kFacet, left_out, "") + end), "") << left_out;
}

TEST(StlReader, BinaryFilesAreTakenByTheirSize) {
  EXPECT_EQ(facets(stl(binary(2, 2))), "2 ");
  EXPECT_EQ(facets(stl(binary(2, 2, "solid made by a program that begins so"))), "2 ");
  EXPECT_EQ(facets(stl(binary(1, 1, "SOLID\nfacet normal 0 0 0"))), "1 ");
  EXPECT_EQ(facets(stl(binary(0, 0))), "0 ");
  EXPECT_EQ(kinds(binary(2, 2)), "");
}

TEST(StlReader, AWrongCountIsAWarning) {
  for (const std::uint32_t count : {0xFFFFFFFFU, 0U, 2U, 4U, 0x7FFFFFFFU}) {
    for (const char* head : {"binary", "solid x"}) {
      const auto scene = stl(binary(count, 3, head));
      EXPECT_EQ(facets(scene), "3 ") << count;
      ASSERT_TRUE(scene);
      EXPECT_EQ(kinds_of(*scene), "wrong_count ") << count;
      EXPECT_TRUE(holds(scene->warnings[0].message, std::to_string(count)));
    }
  }
}

TEST(StlReader, BytesAfterTheFacetsAreAWarning) {
  for (const std::size_t surplus : {1U, 31U, 77U, 1001U}) {
    for (const char* head : {"binary", "solid x"}) {
      const auto scene = stl(binary(3, 3, head) + std::string(surplus, '\0'));
      EXPECT_EQ(facets(scene), "3 ") << surplus;
      ASSERT_TRUE(scene);
      ASSERT_EQ(kinds_of(*scene), "surplus_bytes ") << surplus;
      EXPECT_EQ(scene->warnings[0].count, surplus);
    }
  }
  EXPECT_EQ(kinds(binary(0xFFFFFFFF, 3) + "abc"), "wrong_count surplus_bytes ");
  EXPECT_EQ(kinds(binary(0, 3) + "abc"), "wrong_count surplus_bytes ");
}

TEST(StlReader, FilesThatAreNoStlAreRefused) {
  const std::string whole = binary(3, 3);
  EXPECT_TRUE(
      holds(error_of(stl(whole.substr(0, whole.size() - 1))),
            "cut off: its header announces 3 facets, which need 234 bytes, and it has 233"));
  EXPECT_TRUE(holds(error_of(stl(whole.substr(0, 100))), "cut off"));
  EXPECT_TRUE(holds(error_of(stl(binary(0, 0).substr(0, 83))), "no STL file: it has 83 bytes"));
  EXPECT_TRUE(holds(error_of(stl("hello")), "does not begin with 'solid'"));
  EXPECT_TRUE(holds(error_of(stl(std::string(kFacet))), "does not begin with 'solid'"));
}

}  // namespace
}  // namespace sightline::client::importer::formats
