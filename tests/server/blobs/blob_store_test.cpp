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
const exec::Caller kCaller{"robot", "robot:1"}, kOther{"other", "other:1"};
const auto kNever = std::chrono::hours(1);

/// All different, all of one size.
std::string sheet_blob(std::uint32_t which) {
  tests::TestMesh mesh = tests::planar_sheet(4);
  for (auto& vertex : mesh.vertices) vertex.z = static_cast<float>(which);
  return blob_of(mesh);
}

/// A store, and an account that drops only what this store has.
struct Budgeted {
  explicit Budgeted(std::uint64_t budget, BlobLimits limits = {.idle = kNever})
      : memory(budget), blobs(memory, limits) {
    memory.set_reclaim([this](std::uint64_t bytes, bool) {
      while (
          memory.used() + bytes > memory.budget() &&
          (blobs.drop_set_aside() || blobs.drop_unused_mesh(Unused::kAny) || blobs.drop_idle())) {
      }
    });
  }

  exec::MemoryAccount memory;
  BlobStore blobs;
};

BlobStore::MeshPointer store(BlobStore& blobs, const std::string& blob) {
  const auto upload = blobs.begin(digest_of(blob), 0, kCaller);
  if (!upload) return nullptr;
  EXPECT_TRUE((*upload)->append(0, bytes_of(blob)));
  const auto mesh = blobs.complete(*upload);
  return mesh ? *mesh : nullptr;
}

/// What one of them takes, with its tree, which is empty. Its upload takes no more.
std::uint64_t sheet_bytes() {
  Budgeted roomy(kRoomy);
  const auto mesh = store(roomy.blobs, sheet_blob(0));
  return std::max<std::uint64_t>(roomy.memory.used(), sheet_blob(0).size());
}

TEST(BlobStore, KeepsAMeshByItsDigest) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const std::string blob = blob_of(tests::cube());
  EXPECT_EQ(blobs.find(digest_of(blob)), nullptr);
  const auto mesh = store(blobs, blob);
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(blobs.find(digest_of(blob)), mesh);
  EXPECT_EQ(budgeted.memory.used(exec::Held::kMeshes), mesh->bytes());
  EXPECT_TRUE(blobs.status(digest_of(blob)).complete);
  EXPECT_EQ(blobs.status(digest_of(blob)).committed, blob.size());
}

TEST(BlobStore, AnUploadCanBeResumed) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const std::string blob = blob_of(tests::cube());
  {
    const auto upload = blobs.begin(digest_of(blob), 0, kCaller);
    ASSERT_TRUE(upload);
    ASSERT_TRUE((*upload)->append(0, bytes_of(blob).first(100)));
    EXPECT_EQ(blobs.status(digest_of(blob)).committed, 0u) << "it is in somebody's hands";
    blobs.set_aside(*upload);
  }
  EXPECT_EQ(blobs.status(digest_of(blob)).committed, 100u);
  EXPECT_EQ(blobs.begin(digest_of(blob), 99, kCaller).error().code, Code::kOutOfRange);
  const auto upload = blobs.begin(digest_of(blob), 100, kCaller);
  ASSERT_TRUE(upload);
  ASSERT_TRUE((*upload)->append(100, bytes_of(blob).subspan(100)));
  EXPECT_TRUE(blobs.complete(*upload));
}

TEST(BlobStore, AcceptsBytesInOrderOnly) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const std::string blob = blob_of(tests::cube());
  EXPECT_EQ(blobs.begin(digest_of(blob), 7, kCaller).error().code, Code::kOutOfRange);
  const auto upload = blobs.begin(digest_of(blob), 0, kCaller);
  const Status gap = (*upload)->append(10, bytes_of(blob).first(10));
  ASSERT_FALSE(gap);
  EXPECT_EQ(gap.error().code, Code::kOutOfRange);
  EXPECT_NE(gap.error().message.find("continues at byte 0, not 10"), std::string::npos);
}

TEST(BlobStore, RefusesBytesThatDoNotMatchTheDigest) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const std::string blob = sheet_blob(1);
  const auto upload = blobs.begin(digest_of(sheet_blob(2)), 0, kCaller);
  ASSERT_TRUE((*upload)->append(0, bytes_of(blob)));
  const auto mesh = blobs.complete(*upload);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, Code::kDataLoss);
  EXPECT_EQ(budgeted.memory.used(), 0u);
  EXPECT_EQ(blobs.status(digest_of(sheet_blob(2))).committed, 0u);
}

TEST(BlobStore, NamesTheExceededBudget) {
  const std::string blob = sheet_blob(0);
  const std::uint64_t budget = blob.size() * 3 / 2;
  Budgeted budgeted(budget);
  BlobStore& blobs = budgeted.blobs;
  BlobDigest large = digest_of(blob);
  large.size = budget + 1;
  EXPECT_EQ(blobs.begin(large, 0, kCaller).error().code, Code::kResourceExhausted);
  const auto mesh = store(blobs, blob);
  const auto upload = blobs.begin(digest_of(sheet_blob(1)), 0, kCaller);
  ASSERT_TRUE(upload);
  const Status refused = (*upload)->append(0, bytes_of(sheet_blob(1)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_NE(refused.error().message.find(std::to_string(budgeted.memory.used())),
            std::string::npos);
  EXPECT_NE(refused.error().message.find(std::to_string(budget)), std::string::npos);
}

/// What is declared and does not come holds nothing.
TEST(BlobStore, CountsBytesWhenTheyArrive) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  BlobDigest large = digest_of(sheet_blob(0));
  large.size = kRoomy / 2;
  std::vector<std::shared_ptr<Upload>> claims;
  for (int i = 0; i < 8; ++i) claims.push_back(*blobs.begin(large, 0, kCaller));
  EXPECT_EQ(budgeted.memory.used(), 0u);
  const std::string blob = sheet_blob(1);
  const auto upload = *blobs.begin(digest_of(blob), 0, kCaller);
  ASSERT_TRUE(upload->append(0, bytes_of(blob).first(100)));
  EXPECT_EQ(budgeted.memory.used(exec::Held::kUploads), 100u);
  ASSERT_TRUE(upload->append(100, bytes_of(blob).subspan(100)));
  EXPECT_EQ(budgeted.memory.used(exec::Held::kUploads), blob.size());
  ASSERT_TRUE(blobs.complete(upload));
  EXPECT_EQ(budgeted.memory.used(exec::Held::kUploads), 0u);
}

TEST(BlobStore, LeavesOthersTheirShareOfBytes) {
  const std::string blob = sheet_blob(0);
  Budgeted budgeted(4 * blob.size());
  BlobStore& blobs = budgeted.blobs;
  std::vector<std::shared_ptr<Upload>> held;
  for (std::uint32_t i = 0; i < 3; ++i) {
    held.push_back(*blobs.begin(digest_of(sheet_blob(i)), 0, kCaller));
    ASSERT_TRUE(held.back()->append(0, bytes_of(sheet_blob(i)).first(blob.size() - 1)));
  }
  const auto fourth = *blobs.begin(digest_of(sheet_blob(3)), 0, kCaller);
  const Status refused = fourth->append(0, bytes_of(sheet_blob(3)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, exec::kMemoryBudget);
  EXPECT_NE(refused.error().message.find("of your address is"), std::string::npos)
      << refused.error().message;
  const auto other = *blobs.begin(digest_of(sheet_blob(4)), 0, kOther);
  EXPECT_TRUE(other->append(0, bytes_of(sheet_blob(4))));
  blobs.set_aside(held.front());
  EXPECT_TRUE(fourth->append(0, bytes_of(sheet_blob(3)))) << "the one set aside has gone";
}

TEST(BlobStore, LeavesOthersTheirShareOfUploads) {
  Budgeted budgeted(kRoomy, {.uploads = 8, .idle = kNever});
  BlobStore& blobs = budgeted.blobs;
  const auto begin = [&](std::uint32_t which, const exec::Caller& caller) {
    return blobs.begin(digest_of(sheet_blob(which)), 0, caller);
  };
  std::vector<std::shared_ptr<Upload>> held;
  for (std::uint32_t i = 0; i < 6; ++i)
    held.push_back(*begin(i, {"robot", "robot:" + std::to_string(i / 2)}));
  EXPECT_EQ(begin(6, {"robot", "robot:0"}).error().reason, "TOO_MANY_UPLOADS");
  EXPECT_EQ(begin(6, {"robot", "robot:9"}).error().reason, "TOO_MANY_UPLOADS");
  EXPECT_TRUE(begin(7, kOther));
  blobs.abandon(held.back());
  EXPECT_TRUE(begin(6, {"robot", "robot:9"}));
}

TEST(BlobStore, DropsUnusedMeshesOldestFirst) {
  Budgeted budgeted(3 * sheet_bytes());
  BlobStore& blobs = budgeted.blobs;
  const auto used = store(blobs, sheet_blob(0));
  store(blobs, sheet_blob(1));
  store(blobs, sheet_blob(2));
  ASSERT_NE(store(blobs, sheet_blob(3)), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(0))), nullptr) << "it is in use";
  EXPECT_EQ(blobs.find(digest_of(sheet_blob(1))), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(2))), nullptr);
}

TEST(BlobStore, DropsWhatNothingHasUsedForLong) {
  Budgeted patient(kRoomy, {.unused = kNever});
  ASSERT_NE(store(patient.blobs, sheet_blob(1)), nullptr);
  patient.blobs.drop_unused_meshes();
  EXPECT_TRUE(patient.blobs.has(digest_of(sheet_blob(1))));

  Budgeted hasty(kRoomy, {.unused = std::chrono::seconds(0)});
  const auto used = store(hasty.blobs, sheet_blob(1));
  ASSERT_NE(store(hasty.blobs, sheet_blob(2)), nullptr);
  hasty.blobs.drop_unused_meshes();
  EXPECT_TRUE(hasty.blobs.has(digest_of(sheet_blob(1))));
  EXPECT_FALSE(hasty.blobs.has(digest_of(sheet_blob(2))));
  EXPECT_EQ(hasty.memory.used(exec::Held::kMeshes), used->bytes());
}

TEST(BlobStore, DropsSoonWhatScenesHaveUsed) {
  Budgeted budgeted(kRoomy, {.unused = kNever, .released = std::chrono::seconds(0)});
  BlobStore& blobs = budgeted.blobs;
  for (const std::uint32_t which : {1, 2, 3}) ASSERT_NE(store(blobs, sheet_blob(which)), nullptr);
  {
    const auto used = blobs.use(digest_of(sheet_blob(1)));
    const auto asked_for = blobs.use(digest_of(sheet_blob(2)));
    blobs.drop_unused_meshes();
    EXPECT_NE(blobs.find(digest_of(sheet_blob(1))), nullptr);
  }
  EXPECT_TRUE(blobs.has(digest_of(sheet_blob(2))));
  blobs.drop_unused_meshes();
  EXPECT_EQ(blobs.find(digest_of(sheet_blob(1))), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(2))), nullptr) << "a client is about to use it";
  EXPECT_NE(blobs.find(digest_of(sheet_blob(3))), nullptr) << "it was never used";
}

TEST(BlobStore, AMeshThatHasJustArrivedIsFresh) {
  Budgeted patient(kRoomy), hasty(kRoomy, {.idle = kNever, .fresh = std::chrono::seconds(0)});
  store(patient.blobs, sheet_blob(0));
  EXPECT_FALSE(patient.blobs.drop_unused_mesh(Unused::kStale)) << "its client is about to use it";
  EXPECT_TRUE(patient.blobs.drop_unused_mesh(Unused::kAny));
  store(hasty.blobs, sheet_blob(0));
  EXPECT_TRUE(hasty.blobs.drop_unused_mesh(Unused::kStale));
}

TEST(BlobStore, DropsUploadsSetAsideBeforeMeshes) {
  Budgeted budgeted(2 * sheet_bytes());
  BlobStore& blobs = budgeted.blobs;
  store(blobs, sheet_blob(0));
  blobs.set_aside(*blobs.begin(digest_of(sheet_blob(1)), 0, kCaller));
  ASSERT_NE(store(blobs, sheet_blob(2)), nullptr);
  EXPECT_NE(blobs.find(digest_of(sheet_blob(0))), nullptr);
}

TEST(BlobStore, DropsIdleUploadsForNewOnes) {
  const std::size_t size = sheet_blob(0).size();
  Budgeted budgeted(size * 3 / 2, {.idle = std::chrono::seconds(0)});
  BlobStore& blobs = budgeted.blobs;
  const auto standing = blobs.begin(digest_of(sheet_blob(0)), 0, kCaller);
  ASSERT_TRUE((*standing)->append(0, bytes_of(sheet_blob(0)).first(size - 1)));
  ASSERT_NE(store(blobs, sheet_blob(1)), nullptr);
  const Status dropped = (*standing)->append(size - 1, bytes_of(sheet_blob(0)).last(1));
  ASSERT_FALSE(dropped);
  EXPECT_EQ(dropped.error().code, Code::kAborted);
  EXPECT_EQ(blobs.complete(*standing).error().code, Code::kAborted);
  blobs.set_aside(*standing);
  EXPECT_EQ(blobs.status(digest_of(sheet_blob(0))).committed, 0u);
}

/// A byte now and then is no progress.
TEST(BlobStore, ATrickleOfBytesDoesNotKeepAnUpload) {
  const std::string blob = blob_of(tests::planar_sheet(100));
  ASSERT_GT(blob.size(), 2 * kUploadProgress);
  Budgeted budgeted(kRoomy);
  const auto upload = budgeted.blobs.begin(digest_of(blob), 0, kCaller);
  ASSERT_TRUE(upload);
  const auto begun = (*upload)->last_progress();
  for (std::size_t at = 0; at < 100; ++at)
    ASSERT_TRUE((*upload)->append(at, bytes_of(blob).subspan(at, 1)));
  EXPECT_EQ((*upload)->last_progress(), begun);
  ASSERT_TRUE((*upload)->append(100, bytes_of(blob).subspan(100, kUploadProgress)));
  const auto half = (*upload)->last_progress();
  EXPECT_GT(half, begun);
  ASSERT_TRUE(
      (*upload)->append(100 + kUploadProgress, bytes_of(blob).subspan(100 + kUploadProgress)));
  EXPECT_GT((*upload)->last_progress(), half);
}

TEST(BlobStore, BoundsTheNumberOfUploads) {
  Budgeted budgeted(kRoomy, {.uploads = 2, .idle = kNever});
  BlobStore& blobs = budgeted.blobs;
  const auto first = *blobs.begin(digest_of(sheet_blob(0)), 0, kCaller);
  const auto second = blobs.begin(digest_of(sheet_blob(1)), 0, kOther);
  EXPECT_EQ(blobs.begin(digest_of(sheet_blob(2)), 0, kCaller).error().reason, "TOO_MANY_UPLOADS");
  blobs.set_aside(first);
  EXPECT_TRUE(blobs.begin(digest_of(sheet_blob(2)), 0, kCaller))
      << "a set-aside upload is dropped for a new one";
}

TEST(BlobStore, ReleasesTheBytesOfAnAbandonedUpload) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const auto upload = *blobs.begin(digest_of(sheet_blob(0)), 0, kCaller);
  ASSERT_TRUE(upload->append(0, bytes_of(sheet_blob(0))));
  EXPECT_EQ(budgeted.memory.used(), sheet_blob(0).size());
  blobs.abandon(upload);
  EXPECT_EQ(budgeted.memory.used(), 0u);
}

TEST(BlobStore, RefusesADigestTooSmallForAMesh) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  EXPECT_EQ(blobs.begin(digest_of("abc"), 0, kCaller).error().code, Code::kInvalidArgument);
}

TEST(BlobStore, ManyThreadsMayUploadOneDigest) {
  Budgeted budgeted(kRoomy);
  BlobStore& blobs = budgeted.blobs;
  const std::string blob = blob_of(tests::random_soup(500, 0.1, 1));
  std::vector<BlobStore::MeshPointer> meshes(8);
  std::vector<std::thread> threads;
  for (auto& mesh : meshes) {
    threads.emplace_back([&] {
      const auto upload = blobs.begin(digest_of(blob), 0, kCaller);
      for (std::size_t at = 0; at < blob.size(); at += 1000) {
        ASSERT_TRUE((*upload)->append(
            at, bytes_of(blob).subspan(at, std::min<std::size_t>(1000, blob.size() - at))));
      }
      mesh = *blobs.complete(*upload);
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& mesh : meshes) EXPECT_EQ(mesh, meshes[0]) << "all threads got the stored mesh";
  EXPECT_EQ(budgeted.memory.used(exec::Held::kMeshes), meshes[0]->bytes());
}

}  // namespace
}  // namespace sightline::server::blobs
