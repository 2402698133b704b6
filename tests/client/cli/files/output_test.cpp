// Files that are written completely or not at all.
#include "client/cli/files/output.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

using tests::TempDir;

TEST(Output, ReplacesAFileAtTheEndOnly) {
  const TempDir dir;
  const std::string path = dir.write("file", "old");
  auto output = Output::open(path);
  ASSERT_TRUE(output);
  ASSERT_TRUE(output->write("new content"));
  ASSERT_TRUE(output->write_at_start("NEW"));
  EXPECT_EQ(dir.read("file"), "old");
  ASSERT_TRUE(output->commit());
  EXPECT_EQ(dir.read("file"), "NEW content");
  EXPECT_EQ(dir.names(), "file");
}

TEST(Output, KeepsTheOldFileWithoutACommit) {
  const TempDir dir;
  const std::string path = dir.write("file", "old");
  {
    auto output = Output::open(path);
    ASSERT_TRUE(output);
    ASSERT_TRUE(output->write("half of"));
  }
  EXPECT_EQ(dir.read("file"), "old");
  EXPECT_EQ(dir.names(), "file");
}

TEST(Output, ALinkStaysALink) {
  const TempDir dir;
  std::filesystem::create_symlink(dir.write("file", "old"), dir.path("link"));
  auto output = Output::open(dir.path("link"));
  ASSERT_TRUE(output);
  ASSERT_TRUE(output->write("new"));
  ASSERT_TRUE(output->commit());
  EXPECT_TRUE(std::filesystem::is_symlink(dir.path("link")));
  EXPECT_EQ(dir.read("file"), "new");
}

TEST(Output, DevicesAreWrittenDirectly) {
  auto output = Output::open("/dev/null");
  ASSERT_TRUE(output);
  EXPECT_TRUE(output->write("gone"));
  EXPECT_TRUE(output->commit());
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/null"));
  auto full = Output::open("/dev/full");
  ASSERT_TRUE(full);
  EXPECT_EQ(full->write("x").error().message, "/dev/full: No space left on device");
}

TEST(Output, ReportsAMissingFolder) {
  const TempDir dir;
  const auto output = Output::open(dir.path("none/file"));
  ASSERT_FALSE(output);
  EXPECT_EQ(output.error().message, dir.path("none/file") + ": No such file or directory");
}

}  // namespace
}  // namespace sightline::client::cli::files
