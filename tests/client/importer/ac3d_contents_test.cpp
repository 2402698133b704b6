// Objects that Assimp puts where they are, and others.
#include "client/importer/ac3d_contents.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

// A world with an object, which has a triangle, and an object below it. `of_first` and `of_second`:
// lines of theirs.
std::string file_with(const std::string& of_first, const std::string& of_second = "",
                      bool has_second = true) {
  const std::string triangle =
      "numvert 3\n0 0 0\n1 0 0\n0 1 0\nnumsurf 1\nSURF 0x0\nmat 0\nrefs 3\n0 0 0\n1 0 0\n2 0 0\n";
  const std::string second = "OBJECT poly\n" + of_second + triangle + "kids 0\n";
  return "AC3Db\nMATERIAL \"a\" rgb 1 1 1 amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 0 trans 0\n"
         "OBJECT world\nkids 1\nOBJECT poly\n" +
         of_first + triangle + (has_second ? "kids 1\n" + second : "kids 0\n");
}

std::string first_of(const std::string& text) {
  const tests::TempDir folder;
  const auto scene = import_scene(folder.write("a.ac", text));
  if (!scene) return scene.error().message;
  for (const Warning& warning : scene->warnings) {
    if (warning.kind == "objects_misplaced") return warning.first;
  }
  return "";
}

TEST(Ac3dContents, ObjectsThatAssimpPutsWhereTheyAre) {
  EXPECT_EQ(first_of(file_with("")), "");
  EXPECT_EQ(first_of(file_with("loc 1 2 3\n", "", false)), "");
  EXPECT_EQ(first_of(file_with("", "loc 1 2 3\n")), "");
  EXPECT_EQ(first_of(file_with("rot 1 0 0 0 1 0 0 0 1\n", "rot -1 0 0 0 -1 0 0 0 1\n")), "");
}

TEST(Ac3dContents, ObjectsThatItPutsElsewhere) {
  EXPECT_EQ(first_of(file_with("loc 1 2 3\n")), "line 5") << "what is below is not moved";
  EXPECT_EQ(first_of(file_with("rot 0 1 0 -1 0 0 0 0 1\n")), "line 5") << "turned back";
  EXPECT_EQ(first_of(file_with("", "rot 0 0 1 0 1 0 -1 0 0\n")), "line 18");
  EXPECT_EQ(first_of(file_with("", "loc 1 2 3\nrot -1 0 0 0 -1 0 0 0 1\n")), "line 18")
      << "the place is turned, too";
}

}  // namespace
}  // namespace sightline::client::importer
