// Files with holes.
#include "client/importer/sandbox/stored_bytes.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>

#include "client/importer/sandbox/file_handle.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer::sandbox {
namespace {

constexpr off_t kMiB = 1 << 20;
constexpr std::uint64_t kPage = 65536;  // as large as one of any system

class StoredBytes : public testing::Test {
 protected:
  void write_at(off_t at) {
    ASSERT_EQ(::pwrite(file_.get(), "something", 9, at), 9);
    size_ = std::max<std::uint64_t>(size_, static_cast<std::uint64_t>(at) + 9);
  }
  void resize(off_t size) {
    ASSERT_EQ(::ftruncate(file_.get(), size), 0);
    size_ = static_cast<std::uint64_t>(size);
  }
  std::uint64_t stored() const { return stored_bytes(file_.get(), size_); }

  tests::TempDir dir_;
  FileHandle file_{::open(dir_.path("file").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)};
  std::uint64_t size_ = 0;
};

TEST_F(StoredBytes, AreAllOfAFileWithoutHoles) {
  EXPECT_EQ(stored(), 0U);
  write_at(0);
  EXPECT_EQ(stored(), 9U);
}

TEST_F(StoredBytes, AreNoneOfAHole) {
  resize(kMiB << 13);
  EXPECT_EQ(stored(), 0U);
}

TEST_F(StoredBytes, AreThePiecesBetweenHoles) {
  write_at(kMiB);
  write_at(10 * kMiB);
  resize(kMiB << 13);
  EXPECT_GE(stored(), 18U);
  EXPECT_LE(stored(), 2 * kPage);
}

TEST_F(StoredBytes, AreCountedByBlocksWherePiecesAreMany) {
  for (int i = 0; i < 2 * kMostPieces; ++i) write_at(i * kMiB);
  EXPECT_GE(stored(), static_cast<std::uint64_t>(2 * kMostPieces) * 9);
  EXPECT_LE(stored(), static_cast<std::uint64_t>(2 * kMostPieces) * kPage);
}

}  // namespace
}  // namespace sightline::client::importer::sandbox
