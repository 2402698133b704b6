// What a scene file may open, and what not.
#include "client/importer/sandbox/folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer::sandbox {
namespace {

namespace fs = std::filesystem;
using tests::TempDir;

/// DIR/in/scene.gltf, with a folder beside it and a secret above it.
struct Tree {
  Tree() {
    fs::create_directories(dir.path("in/parts"));
    dir.write("secret", "secret");
    dir.write("in/scene.gltf", "scene");
    dir.write("in/parts/a.bin", "part");
  }
  SceneFolder open() const {
    return *SceneFolder::open(dir.path("in/scene.gltf"), {.fixed = 1 << 20, .per_byte = 64});
  }

  TempDir dir;
};

bool opens(SceneFolder& folder, const std::string& name) {
  return folder.open_file(name).has_value();
}

TEST(SceneFolder, OpensTheSceneAndFilesBelow) {
  const Tree tree;
  SceneFolder folder = tree.open();
  const auto part = folder.open_file("parts/a.bin");
  ASSERT_TRUE(part);
  EXPECT_EQ(part->bytes, 4U);
  EXPECT_TRUE(opens(folder, "scene.gltf"));
  EXPECT_TRUE(opens(folder, "./scene.gltf"));
  EXPECT_TRUE(opens(folder, "parts/../parts/a.bin"));
  EXPECT_EQ(folder.bytes(), 9U) << "each file counts once";
  EXPECT_FALSE(opens(folder, "none.bin"));
  EXPECT_TRUE(folder.refusals().empty());
}

TEST(SceneFolder, OpensNothingElsewhere) {
  const Tree tree;
  SceneFolder folder = tree.open();
  for (const std::string& name :
       {std::string("../secret"), tree.dir.path("secret"), tree.dir.path("in/parts/a.bin"),
        std::string("parts/../../secret"), std::string("/proc/self/environ")}) {
    EXPECT_FALSE(opens(folder, name)) << name;
  }
  ASSERT_FALSE(folder.refusals().empty());
  EXPECT_EQ(folder.refusals()[0],
            "it names '../secret', which is outside the folder of the scene file");
}

TEST(SceneFolder, FollowsLinksThatStayBelow) {
  const Tree tree;
  fs::create_symlink("parts/a.bin", tree.dir.path("in/inside"));
  fs::create_symlink("../secret", tree.dir.path("in/outside"));
  fs::create_symlink(tree.dir.path("secret"), tree.dir.path("in/absolute"));
  fs::create_directory_symlink("..", tree.dir.path("in/up"));
  SceneFolder folder = tree.open();
  EXPECT_TRUE(opens(folder, "inside"));
  EXPECT_FALSE(opens(folder, "outside"));
  EXPECT_FALSE(opens(folder, "absolute"));
  EXPECT_FALSE(opens(folder, "up/secret"));
  EXPECT_EQ(folder.refusals().size(), 3U);
}

TEST(SceneFolder, OpensRegularFilesOnly) {
  const Tree tree;
  ASSERT_EQ(mkfifo(tree.dir.path("in/pipe").c_str(), 0600), 0);
  SceneFolder folder = tree.open();
  EXPECT_FALSE(opens(folder, "pipe"));
  EXPECT_FALSE(opens(folder, "parts"));
  EXPECT_EQ(folder.refusals()[0], "it names 'pipe', which is a pipe");
  EXPECT_EQ(folder.refusals()[1], "it names 'parts', which is a directory");
}

TEST(SceneFolder, CountsAFileOnceUnderAllItsNames) {
  const Tree tree;
  fs::create_hard_link(tree.dir.path("in/parts/a.bin"), tree.dir.path("in/hard"));
  fs::create_symlink("parts/a.bin", tree.dir.path("in/soft"));
  SceneFolder folder = tree.open();
  const std::uint64_t number = folder.open_file("hard")->number;
  for (const char* const name : {"parts/a.bin", "soft", "./hard"})
    EXPECT_EQ(folder.open_file(name)->number, number) << name;
  EXPECT_NE(folder.open_file("scene.gltf")->number, number);
  EXPECT_EQ(folder.bytes(), 9U);
}

TEST(SceneFolder, CountsAFileThatGrowsAsItWas) {
  const Tree tree;
  SceneFolder folder = tree.open();
  EXPECT_TRUE(opens(folder, "parts/a.bin"));
  fs::resize_file(tree.dir.path("in/parts/a.bin"), std::uintmax_t{1} << 40);
  EXPECT_TRUE(opens(folder, "parts/a.bin"));
  EXPECT_EQ(folder.bytes(), 4U);
}

TEST(SceneFolder, GivesNothingForHoles) {
  const Tree tree;
  tree.dir.write("in/small.bin", "");
  tree.dir.write("in/large.bin", "");
  fs::resize_file(tree.dir.path("in/small.bin"), 1 << 19);
  fs::resize_file(tree.dir.path("in/large.bin"), std::uintmax_t{8} << 30);
  SceneFolder folder = tree.open();
  const auto small = folder.open_file("small.bin");
  ASSERT_TRUE(small);
  EXPECT_EQ(small->bytes, 1U << 19);
  EXPECT_EQ(folder.bytes(), 0U);
  EXPECT_FALSE(opens(folder, "large.bin")) << "its pages would take memory";
  EXPECT_EQ(folder.refusals()[0],
            "it names 'large.bin', which is a hole: of its 8589934592 bytes 0 are stored");
  EXPECT_TRUE(opens(folder, "parts/a.bin"));
  EXPECT_EQ(folder.bytes(), 4U);
}

TEST(SceneFolder, GivesManySmallHolesNoMoreThanOneLargeOne) {
  const Tree tree;
  SceneFolder folder = tree.open();
  int opened = 0;
  for (int i = 0; i < 8; ++i) {
    const std::string name = "in/hole" + std::to_string(i);
    tree.dir.write(name, "");
    fs::resize_file(tree.dir.path(name), 1 << 18);
    opened += opens(folder, name.substr(3)) ? 1 : 0;
  }
  EXPECT_EQ(opened, 4) << "a MiB";
}

TEST(OpenRegular, FollowsLinksAndNamesWhatIsNoFile) {
  const Tree tree;
  fs::create_symlink("in/scene.gltf", tree.dir.path("link.gltf"));
  ASSERT_EQ(mkfifo(tree.dir.path("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(open_regular(tree.dir.path("link.gltf")));
  EXPECT_EQ(open_regular(tree.dir.path("pipe")).error().message,
            tree.dir.path("pipe") + ": is a pipe");
  EXPECT_EQ(open_regular("/dev/zero").error().message, "/dev/zero: is a device");
  EXPECT_EQ(open_regular(tree.dir.path("in")).error().message,
            tree.dir.path("in") + ": is a directory");
  EXPECT_NE(open_regular(tree.dir.path("no")).error().message.find("No such file"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::sandbox
