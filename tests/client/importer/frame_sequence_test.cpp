// Folders of frames: their order, their common topology, their lattice.
#include "client/importer/frame_sequence.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

using tests::TempDir;

// A square of two triangles at height z, and a second square that does not move.
std::string squares(double z, double x = 0) {
  std::string text = "o moving\n";
  for (const auto& [dx, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    text += fmt::format("v {} {} {}\n", x + dx, y, z);
  text += "f 1 2 3\nf 1 3 4\no still\n";
  for (const auto& [dx, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    text += fmt::format("v {} {} -1\n", x + dx, y);
  return text + "f 5 6 7\nf 5 7 8\n";
}

// Four vertices at height z, with these faces.
std::string sheet(double z, const std::vector<std::string>& faces) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face {0}\nproperty list uchar int vertex_indices\nend_header\n0 0 {1}\n1 0 "
      "{1}\n1 1 {1}\n0 1 {1}\n",
      faces.size(), z);
  for (const std::string& face : faces) text += "3 " + face + "\n";
  return text;
}

std::string error_of(const Result<FrameSequence>& sequence) {
  return sequence ? "" : sequence.error().message;
}

TEST(FrameSequence, HasOnlyChangingMeshes) {
  const TempDir dir;
  for (int k = 1; k <= 3; ++k) dir.write(fmt::format("f{}.obj", k), squares(k));
  const auto sequence = import_sequence(dir.path(""));
  ASSERT_TRUE(sequence) << error_of(sequence);
  ASSERT_EQ(sequence->frames.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    const Pose& frame = sequence->frames[k];
    EXPECT_TRUE(frame.placed.empty());
    ASSERT_EQ(frame.shaped.size(), 1U);
    ASSERT_EQ(frame.shaped[0].nodes.size(), 1U);
    EXPECT_EQ(sequence->scene.nodes[frame.shaped[0].nodes[0]].name, "moving");
    EXPECT_EQ(frame.shaped[0].vertices[0][2], static_cast<float>(k + 1));
  }
  EXPECT_EQ(sequence->frames[0].shaped[0].vertices, sequence->scene.meshes[0].vertices);
}

TEST(FrameSequence, OrdersNumbersInNamesByValue) {
  const TempDir dir;
  for (const char* name : {"f10.obj", "f9.obj", "f009.obj", "f1a.obj", "f1.obj", "e99.obj"})
    dir.write(name, squares(1));
  dir.write("notes.txt", "not a frame");
  dir.write(".f0.obj", squares(1));
  std::filesystem::create_directory(dir.path("f0.obj"));
  const auto files = frame_files(dir.path(""));
  ASSERT_TRUE(files);
  std::string names;
  for (const std::string& file : *files) {
    names += std::filesystem::path(file).filename().string() + " ";
  }
  EXPECT_EQ(names, "e99.obj f1.obj f1a.obj f009.obj f9.obj f10.obj ");
}

TEST(FrameSequence, NamesTheFirstFrameOfAnotherTopology) {
  const TempDir dir;
  dir.write("f1.ply", sheet(1, {"0 1 2", "0 2 3"}));
  dir.write("f2.ply", sheet(2, {"0 1 2", "0 2 3"}));
  dir.write("f3.ply", sheet(3, {"0 1 2", "0 1 3"}));
  dir.write("f4.ply", sheet(4, {"0 1 2"}));
  const std::string error = error_of(import_sequence(dir.path("")));
  EXPECT_NE(error.find("f3.ply: not the topology of"), std::string::npos) << error;
  EXPECT_NE(error.find("its face 1 names vertices 0 1 3, in the first frame 0 2 3"),
            std::string::npos)
      << error;
  std::filesystem::remove(dir.path("f3.ply"));
  EXPECT_NE(error_of(import_sequence(dir.path(""))).find("f4.ply: not the topology"),
            std::string::npos);
}

TEST(FrameSequence, RefusesAFolderWithoutFrames) {
  const TempDir dir;
  EXPECT_NE(error_of(import_sequence(dir.path(""))).find("holds no scene file"), std::string::npos);
  EXPECT_NE(error_of(import_sequence(dir.path("none"))).find("No such file"), std::string::npos);
}

TEST(FrameSequence, AllFramesAreOnTheLatticeOfTheFirst) {
  const TempDir dir;
  dir.write("f1.obj", squares(1, 4096));
  dir.write("f2.obj", squares(2, 4099.5));
  const auto sequence = import_sequence(dir.path(""));
  ASSERT_TRUE(sequence) << error_of(sequence);
  const auto x_of = [&](std::size_t frame) {
    return sequence->frames[frame].shaped[0].vertices[0][0];
  };
  EXPECT_LT(x_of(0), 100) << "rebased";
  EXPECT_EQ(x_of(1) - x_of(0), 3.5F);
}

TEST(FrameSequence, AFrameThatTheLatticeCannotHoldIsAnError) {
  const TempDir dir;
  dir.write("f1.obj", squares(1, 4'096'000));
  dir.write("f2.obj", squares(2, 0.3));
  EXPECT_NE(error_of(import_sequence(dir.path(""))).find("f2.obj: lies too far"),
            std::string::npos);
}

TEST(FrameSequence, ReadsTheGallopingHorse) {
  const char* folder = std::getenv("SIGHTLINE_SCENES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  const auto sequence = import_sequence(std::string(folder) + "/horse_gallop");
  ASSERT_TRUE(sequence) << error_of(sequence);
  EXPECT_EQ(sequence->frames.size(), 48U);
  EXPECT_EQ(sequence->scene.meshes.at(0).faces.size(), 16843U);
  EXPECT_EQ(sequence->frames[7].shaped.at(0).vertices.size(), 8431U);
}

}  // namespace
}  // namespace sightline::client::importer
