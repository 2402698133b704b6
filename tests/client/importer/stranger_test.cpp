// Scene files from strangers: they reach no other file, and Assimp's death is one clear error.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

using tests::TempDir;

/// A triangle whose vertices are the first 36 bytes of another file.
std::string gltf_of(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":")" + uri + R"("}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})";
}

std::string error_of(const Result<ImportedScene>& scene) {
  return scene ? "" : scene.error().message;
}

TEST(Stranger, ReadsBuffersOfItsFolderOnly) {
  const TempDir dir;
  std::filesystem::create_directories(dir.path("in/parts"));
  const std::string bytes(36, '\0');
  dir.write("secret", bytes);
  dir.write("in/parts/own.bin", bytes);
  EXPECT_TRUE(import_scene(dir.write("in/own.gltf", gltf_of("parts/own.bin"))));
  std::filesystem::create_symlink(dir.path("secret"), dir.path("in/link.bin"));
  for (const std::string& uri : {std::string("../secret"), dir.path("secret"),
                                 std::string("link.bin"), std::string("/etc/passwd")}) {
    const auto scene = import_scene(dir.write("in/other.gltf", gltf_of(uri)));
    ASSERT_FALSE(scene) << uri;
    EXPECT_NE(error_of(scene).find("is outside the folder"), std::string::npos) << error_of(scene);
  }
}

TEST(Stranger, MaterialsAreNotAskedFor) {
  const TempDir dir;
  const auto scene =
      import_scene(dir.write("a.obj", "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_TRUE(scene) << error_of(scene);
  ASSERT_EQ(scene->warnings.size(), 1U);
  EXPECT_EQ(scene->warnings[0].kind, "open_edges");
}

TEST(Stranger, ACutFileIsAnErrorOrAWarning) {
  const TempDir dir;
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
  const auto first_kind = [](const Result<ImportedScene>& scene) {
    return scene->warnings.at(0).kind;
  };
  EXPECT_EQ(first_kind(import_scene(dir.write("whole.obj", start + "\n"))), "open_edges");
  EXPECT_EQ(first_kind(import_scene(dir.write("cut.obj", start))), "cut_off");
  EXPECT_FALSE(import_scene(dir.write("cut.obj", start + "\nf 1")));
  EXPECT_NE(
      error_of(import_scene(dir.write("cut.ifc", "ISO-10303-21;\nHEADER;\n"))).find("cut off"),
      std::string::npos);
}

TEST(Stranger, PipesAndDevicesAreRefused) {
  const TempDir dir;
  ASSERT_EQ(mkfifo(dir.path("a.obj").c_str(), 0600), 0);
  EXPECT_EQ(error_of(import_scene(dir.path("a.obj"))), dir.path("a.obj") + ": is a pipe");
  EXPECT_EQ(error_of(import_scene("/dev/zero")), "/dev/zero: is a device");
}

// Assimp's recursion over nodes that instance themselves has no end.
TEST(Stranger, ACrashOfAssimpIsAnError) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("self.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_nodes>
<node id="n"><instance_node url="#n"/><instance_node url="#n"/></node></library_nodes>
<library_visual_scenes><visual_scene id="v"><node id="r"><instance_node url="#n"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#v"/></scene></COLLADA>)"));
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().code, Code::kInvalidArgument);
  EXPECT_NE(error_of(scene).find("self.dae: "), std::string::npos);
}

// An accessor of two billion vertices, none of them in the file.
TEST(Stranger, AnExplosionOfMemoryIsAnError) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("sparse.gltf", R"({"asset":{"version":"2.0"},
    "buffers":[{"byteLength":4,"uri":"data:application/octet-stream;base64,AAAAAA=="}],
    "bufferViews":[{"buffer":0,"byteLength":4}],
    "accessors":[{"componentType":5126,"count":2000000000,"type":"VEC3","sparse":{"count":1,
      "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})"));
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().code, Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::client::importer
