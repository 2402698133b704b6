// Who may use a data directory.
#include "server/store/data_directory.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/server/store/directory.h"
#include "tests/server/store/failing_files.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::Directory;
using tests::reason_of;

/// A file system that says that it is on a network.
class NetworkFiles final : public tests::FailingFiles {
 public:
  Result<std::string> network(const Path&) override { return std::string("NFS"); }
};

TEST(DataDirectory, IsUsedByOne) {
  const Directory directory;
  auto first = tests::open_store(directory.path());
  const auto second = SqliteStore::open(directory.path());
  ASSERT_EQ(reason_of(second), "DATA_DIR_IN_USE");
  EXPECT_NE(second.error().message.find(directory.path().string()), std::string::npos);
  first.reset();
  EXPECT_NE(tests::open_store(directory.path()), nullptr);
}

TEST(DataDirectory, IsRefusedOnANetwork) {
  const Directory directory;
  NetworkFiles files;
  const auto refused = SqliteStore::open(directory.path(), {}, files);
  ASSERT_EQ(reason_of(refused), "NETWORK_FILE_SYSTEM");
  EXPECT_NE(refused.error().message.find("NFS"), std::string::npos);
}

TEST(DataDirectory, NamesADamagedDatabase) {
  const Directory directory;
  std::ofstream(database_file(directory.path())) << std::string(8192, 'x');
  const auto refused = SqliteStore::open(directory.path());
  ASSERT_EQ(reason_of(refused), "STORE_CORRUPT");
  EXPECT_EQ(refused.error().code, Code::kDataLoss);
  EXPECT_NE(refused.error().message.find("sightlined doctor " + directory.path().string()),
            std::string::npos);
}

TEST(DataDirectory, IsClearedOfFilesThatADeadProcessWasWriting) {
  const Directory directory;
  tests::open_store(directory.path()).reset();
  const auto left = directory.path() / "blobs" / "tmp" / "0";
  std::ofstream(left) << "half a blob";
  tests::open_store(directory.path()).reset();
  EXPECT_FALSE(std::filesystem::exists(left));
}

}  // namespace
}  // namespace sightline::server::store
