// The data directory and the port file.
#include "server/state_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace sightline::server {
namespace {

namespace fs = std::filesystem;

class StateFiles : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "sightline-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(StateFiles, CreatesTheDataDirectory) {
  EXPECT_TRUE(make_data_dir(root_ / "a" / "b"));
  EXPECT_TRUE(fs::is_directory(root_ / "a" / "b"));
  EXPECT_TRUE(make_data_dir(root_ / "a" / "b")) << "again";
  EXPECT_TRUE(make_data_dir({}));
}

TEST_F(StateFiles, RefusesADirectoryThatIsAFile) {
  std::ofstream(root_ / "file") << "x";
  const Status status = make_data_dir(root_ / "file");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::kFailedPrecondition);
  EXPECT_FALSE(make_data_dir(root_ / "file" / "below"));
}

TEST_F(StateFiles, WritesThePortFileAtomicallyAndLeavesNoOtherFile) {
  ASSERT_TRUE(write_port_file(root_ / "port", 50151));
  std::string text;
  std::getline(std::ifstream(root_ / "port"), text);
  EXPECT_EQ(text, "50151");
  EXPECT_EQ(std::distance(fs::directory_iterator(root_), {}), 1);
  EXPECT_FALSE(write_port_file(root_ / "none" / "port", 1));
  EXPECT_TRUE(write_port_file({}, 1));
}

}  // namespace
}  // namespace sightline::server
