// Meshes in PostgreSQL: copies on the machine of a server, their bound, and damage.
#include <gtest/gtest.h>

#include <string>

#include "tests/server/store/postgres/postgres_test.h"

namespace sightline::server::store::postgres {
namespace {

using tests::blob_bytes;
using tests::digest_of_blob;
using tests::Process;
using tests::reason_of;
using tests::store_blob;

class CopiedMeshes : public tests::PostgresTest {};

TEST_F(CopiedMeshes, ReadsBlobsThatOthersHaveStored) {
  const auto one = open();
  const auto two = two_.open(uri());
  const std::string large = blob_bytes(1, 11'000'000);
  ASSERT_TRUE(store_blob(*one, large).ok());
  EXPECT_TRUE(two->has_blob(digest_of_blob(large)));
  EXPECT_EQ(*tests::load_blob(*two, digest_of_blob(large)), large);
  EXPECT_EQ(two->figures().bytes_on_disk, large.size());
  run("DELETE FROM content_chunk");
  EXPECT_EQ(*tests::load_blob(*two, digest_of_blob(large)), large) << "from its copy";
}

TEST_F(CopiedMeshes, BoundsTheCopiesOfBlobs) {
  StoreLimits limits = tests::small_disk();
  limits.cache_bytes = 2500;
  const auto store = open(limits);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(store_blob(*store, blob_bytes(i)).ok());
    EXPECT_LE(store->figures().bytes_on_disk, limits.cache_bytes);
  }
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(*tests::load_blob(*store, digest_of_blob(blob_bytes(i))), blob_bytes(i));
  const std::string large = blob_bytes(6, 5000);
  ASSERT_TRUE(store_blob(*store, large).ok());
  EXPECT_EQ(*tests::load_blob(*store, digest_of_blob(large)), large);
}

TEST_F(CopiedMeshes, ADamagedBlobCanBeStoredAgain) {
  const auto one = open();
  const auto two = two_.open(uri());
  const std::string bytes = blob_bytes(1);
  const auto digest = digest_of_blob(bytes);
  ASSERT_TRUE(store_blob(*one, bytes).ok());
  run("UPDATE content_chunk SET data = 'wrong'");
  EXPECT_EQ(reason_of(tests::load_blob(*two, digest)), "BLOB_CORRUPT");
  EXPECT_FALSE(two->has_blob(digest));
  ASSERT_TRUE(store_blob(*two, bytes).ok());
  EXPECT_TRUE(two->has_blob(digest));
  EXPECT_EQ(*tests::load_blob(*Process().open(uri()), digest), bytes);
}

}  // namespace
}  // namespace sightline::server::store::postgres
