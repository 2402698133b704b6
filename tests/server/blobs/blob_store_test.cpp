// Uploads, the meshes made from them, and the memory that both share.
#include "server/blobs/blob_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/blobs/blob_of.h"
#include "tests/support/scenes.h"

namespace sightline::server::blobs {
namespace {

using tests::blob_of;
using tests::bytes_of;
using tests::digest_of;

constexpr std::uint64_t kRoomy = 1 << 20;
const auto kNever = std::chrono::hours(1);

/// All different, all of one size.
std::string sheet_blob(std::uint32_t which) {
  tests::TestMesh mesh = tests::planar_sheet(4);
  for (auto& vertex : mesh.vertices) vertex.z = static_cast<float>(which);
  return blob_of(mesh);
}

BlobStore::MeshPointer store(BlobStore& blobs, const std::string& blob) {
  const auto upload = blobs.begin(digest_of(blob), 0);
  if (!upload) return nullptr;
  EXPECT_TRUE((*upload)->append(0, bytes_of(blob)));
  const auto mesh = blobs.complete(*upload);
  return mesh ? *mesh : nullptr;
}

TEST(BlobStore, KeepsAMeshByItsDigest) {
  BlobStore blobs({kRoomy});
  const std::string blob = blob_of(tests::cube());
  EXPECT_EQ(blobs.find(digest_of(blob)), nullptr);
  const auto mesh = store(blobs, blob);
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(blobs.find(digest_of(blob)), mesh);
  EXPECT_EQ(blobs.bytes_used(), mesh->bytes());
  EXPECT_TRUE(blobs.status(digest_of(blob)).complete);
  EXPECT_EQ(blobs.status(digest_of(blob)).committed, blob.size());
}

TEST(BlobStore, AnUploadCanBeResumed) {
  BlobStore blobs({kRoomy});
  const std::string blob = blob_of(tests::cube());
  {
    const auto upload = blobs.begin(digest_of(blob), 0);
    ASSERT_TRUE(upload);
    ASSERT_TRUE((*upload)->append(0, bytes_of(blob).first(100)));
    EXPECT_EQ(blobs.status(digest_of(blob)).committed, 0u) << "it is in somebody's hands";
    blobs.set_aside(*upload);
  }
  EXPECT_EQ(blobs.status(digest_of(blob)).committed, 100u);
  EXPECT_EQ(blobs.begin(digest_of(blob), 99).error().code, Code::kOutOfRange);
  const auto upload = blobs.begin(digest_of(blob), 100);
  ASSERT_TRUE(upload);
  ASSERT_TRUE((*upload)->append(100, bytes_of(blob).subspan(100)));
  EXPECT_TRUE(blobs.complete(*upload));
}

TEST(BlobStore, AcceptsBytesInOrderOnly) {
  BlobStore blobs({kRoomy});
  const std::string blob = blob_of(tests::cube());
  EXPECT_EQ(blobs.begin(digest_of(blob), 7).error().code, Code::kOutOfRange);
  const auto upload = blobs.begin(digest_of(blob), 0);
  const Status gap = (*upload)->append(10, bytes_of(blob).first(10));
  ASSERT_FALSE(gap);
  EXPECT_EQ(gap.error().code, Code::kOutOfRange);
  EXPECT_NE(gap.error().message.find("continues at byte 0, not 10"), std::string::npos);
}

TEST(BlobStore, RefusesBytesThatDoNotMatchTheDigest) {
  BlobStore blobs({kRoomy});
  const std::string blob = sheet_blob(1);
  const auto upload = blobs.begin(digest_of(sheet_blob(2)), 0);
  ASSERT_TRUE((*upload)->append(0, bytes_of(blob)));
  const auto mesh = blobs.complete(*upload);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, Code::kDataLoss);
  EXPECT_EQ(blobs.bytes_used(), 0u);
  EXPECT_EQ(blobs.status(digest_of(sheet_blob(2))).committed, 0u);
}

TEST(BlobStore, NamesTheExceededBudget) {
  const std::string blob = sheet_blob(0);
  BlobStore blobs({.memory_budget = blob.size() + 10, .idle = kNever});
  BlobDigest large = digest_of(blob);
  large.size = blob.size() + 11;
  EXPECT_EQ(blobs.begin(large, 0).error().code, Code::kResourceExhausted);
  const auto mesh = store(blobs, blob);
  const auto refused = blobs.begin(digest_of(sheet_blob(1)), 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_NE(refused.error().message.find(std::to_string(blobs.bytes_used())), std::string::npos);
  EXPECT_NE(refused.error().message.find(std::to_string(blob.size() + 10)), std::string::npos);
}

TEST(BlobStore, DropsUnusedMeshesOldestFirst) {
  const std::size_t size = sheet_blob(0).size();
  BlobStore blobs({.memory_budget = 3 * size, .idle = kNever});
  const auto used = store(blobs, sheet_blob(0));
  store(blobs, sheet_blob(1));
  store(blobs, sheet_blob(2));
  ASSERT_NE(store(blobs, sheet_blob(3)), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(0))), nullptr) << "it is in use";
  EXPECT_EQ(blobs.find(digest_of(sheet_blob(1))), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(2))), nullptr);
}

TEST(BlobStore, DropsUploadsSetAsideBeforeMeshes) {
  const std::size_t size = sheet_blob(0).size();
  BlobStore blobs({.memory_budget = 2 * size, .idle = kNever});
  store(blobs, sheet_blob(0));
  blobs.set_aside(*blobs.begin(digest_of(sheet_blob(1)), 0));
  ASSERT_NE(store(blobs, sheet_blob(2)), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(0))), nullptr);
}

TEST(BlobStore, DropsIdleUploadsForNewOnes) {
  const std::size_t size = sheet_blob(0).size();
  BlobStore blobs({.memory_budget = size, .idle = std::chrono::seconds(0)});
  const auto standing = blobs.begin(digest_of(sheet_blob(0)), 0);
  ASSERT_NE(store(blobs, sheet_blob(1)), nullptr);
  const Status dropped = (*standing)->append(0, bytes_of(sheet_blob(0)));
  ASSERT_FALSE(dropped);
  EXPECT_EQ(dropped.error().code, Code::kAborted);
  EXPECT_EQ(blobs.complete(*standing).error().code, Code::kAborted);
  blobs.set_aside(*standing);
  EXPECT_EQ(blobs.status(digest_of(sheet_blob(0))).committed, 0u);
}

TEST(BlobStore, BoundsTheNumberOfUploads) {
  BlobStore blobs({.memory_budget = kRoomy, .uploads = 2, .idle = kNever});
  const auto first = blobs.begin(digest_of(sheet_blob(0)), 0);
  const auto second = blobs.begin(digest_of(sheet_blob(1)), 0);
  EXPECT_EQ(blobs.begin(digest_of(sheet_blob(2)), 0).error().reason, "TOO_MANY_UPLOADS");
  blobs.set_aside(*first);
  EXPECT_TRUE(blobs.begin(digest_of(sheet_blob(2)), 0))
      << "a set-aside upload is dropped for a new one";
}

TEST(BlobStore, ReleasesTheBytesOfAnAbandonedUpload) {
  BlobStore blobs({kRoomy});
  const auto upload = blobs.begin(digest_of(sheet_blob(0)), 0);
  EXPECT_EQ(blobs.bytes_used(), sheet_blob(0).size());
  blobs.abandon(*upload);
  EXPECT_EQ(blobs.bytes_used(), 0u);
}

TEST(BlobStore, RefusesADigestTooSmallForAMesh) {
  BlobStore blobs({kRoomy});
  EXPECT_EQ(blobs.begin(digest_of("abc"), 0).error().code, Code::kInvalidArgument);
}

TEST(BlobStore, ManyThreadsMayUploadOneDigest) {
  BlobStore blobs({kRoomy});
  const std::string blob = blob_of(tests::random_soup(500, 0.1, 1));
  std::vector<BlobStore::MeshPointer> meshes(8);
  std::vector<std::thread> threads;
  for (auto& mesh : meshes) {
    threads.emplace_back([&] {
      const auto upload = blobs.begin(digest_of(blob), 0);
      for (std::size_t at = 0; at < blob.size(); at += 1000) {
        ASSERT_TRUE((*upload)->append(
            at, bytes_of(blob).subspan(at, std::min<std::size_t>(1000, blob.size() - at))));
      }
      mesh = *blobs.complete(*upload);
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& mesh : meshes) EXPECT_EQ(mesh, meshes[0]) << "all threads got the stored mesh";
  EXPECT_EQ(blobs.bytes_used(), meshes[0]->bytes());
}

}  // namespace
}  // namespace sightline::server::blobs
