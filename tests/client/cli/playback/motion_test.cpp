// Files and folders as motions.
#include "client/cli/playback/motion.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/client/importer/gltf_file.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::playback {
namespace {

using tests::TempDir;

std::string error_of(const Result<Motion>& motion) { return motion ? "" : motion.error().message; }

TEST(Motion, OfASkinMovesABoneAndAMesh) {
  const TempDir dir;
  const auto motion = open_motion({.path = dir.write("strip.gltf", tests::bending_strip().text())});
  ASSERT_TRUE(motion) << error_of(motion);
  EXPECT_NEAR(motion->seconds, 1, 1e-6);
  EXPECT_FALSE(motion->is_cyclic);
  ASSERT_EQ(motion->placed.size(), 1U);
  EXPECT_EQ(motion->scene.nodes[motion->placed[0]].name, "knee");
  ASSERT_EQ(motion->shaped.size(), 1U);
  EXPECT_EQ(motion->scene.nodes[motion->shaped[0]].name, "strip");
  const auto mobilities = motion->mobilities();
  for (std::size_t i = 0; i < mobilities.size(); ++i) {
    const std::string& name = motion->scene.nodes[i].name;
    EXPECT_EQ(mobilities[i], name == "strip"  ? Mobility::kDeforming
                             : name == "knee" ? Mobility::kRigid
                                              : Mobility::kStatic)
        << name;
  }
}

TEST(Motion, DescendantsOfAMovedNodeMoveWithIt) {
  const TempDir dir;
  tests::GltfFile file = tests::triangle_under_root();
  file.animate(0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  const auto motion = open_motion({.path = dir.write("file.gltf", file.text())});
  ASSERT_TRUE(motion) << error_of(motion);
  EXPECT_EQ(motion->mobilities(), std::vector<Mobility>(2, Mobility::kRigid));
}

TEST(Motion, OfAFolderShowsOneFrameAtATime) {
  const TempDir dir;
  for (int k = 0; k < 4; ++k)
    dir.write(fmt::format("f{}.obj", k),
              fmt::format("v 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf 1 2 3\n", k));
  const auto motion = open_motion({.path = dir.path(""), .fps = 8});
  ASSERT_TRUE(motion) << error_of(motion);
  EXPECT_EQ(motion->seconds, 0.5);
  EXPECT_TRUE(motion->is_cyclic);
  EXPECT_EQ(motion->shaped.size(), 1U);
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(motion->pose(k / 8.0).shaped.at(0).vertices[0][2], static_cast<float>(k));
  EXPECT_EQ(motion->pose(0.24).shaped.at(0).vertices[0][2], 1);
}

TEST(Motion, AnimationsAreChosenByNameOrNumber) {
  const TempDir dir;
  tests::GltfFile file = tests::triangle_under_root();
  file.animate(1, "translation", {0, 2}, {0, 0, 0, 1, 0, 0});
  file.json["animations"][0]["name"] = "walk";
  const std::string path = dir.write("file.gltf", file.text());
  EXPECT_EQ(open_motion({.path = path, .animation = "walk"})->name, "walk");
  EXPECT_EQ(open_motion({.path = path, .animation = "0"})->name, "walk");
  for (const char* wrong : {"run", "1", "-1", "0x"}) {
    const std::string error = error_of(open_motion({.path = path, .animation = wrong}));
    EXPECT_NE(error.find(fmt::format("has no animation '{}', only 0 'walk' (2 s)", wrong)),
              std::string::npos)
        << error;
  }
}

TEST(Motion, AFileWithoutAnimationIsRefused) {
  const TempDir dir;
  const std::string unanimated = dir.write("still.gltf", tests::triangle_under_root().text());
  EXPECT_EQ(error_of(open_motion({.path = unanimated})), unanimated + ": holds no animation");
  dir.write("frames.obj", "");
  const TempDir alike;
  for (const char* name : {"a.obj", "b.obj"})
    alike.write(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_NE(error_of(open_motion({.path = alike.path("")})).find("its 2 frames are all alike"),
            std::string::npos);
  const TempDir empty;
  EXPECT_NE(error_of(open_motion({.path = empty.path("")})).find("holds no scene file"),
            std::string::npos);
  EXPECT_NE(error_of(open_motion({.path = dir.path("none.gltf")})).find("No such file"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline::client::cli::playback
