// Meshes in PostgreSQL: copies on the machine of a server, their bound, and damage.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

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

/// Of meshes that are written with others, and of one that is written alone.
constexpr std::size_t kSizes[] = {1000, 100'000};

TEST_F(CopiedMeshes, ADamagedBlobCanBeStoredAgain) {
  const auto one = open();
  const auto two = two_.open(uri());
  for (const std::size_t size : kSizes) {
    const std::string bytes = blob_bytes(1, size);
    const auto digest = digest_of_blob(bytes);
    ASSERT_TRUE(store_blob(*one, bytes).ok());
    run("UPDATE content_chunk SET data = 'wrong'");
    EXPECT_EQ(reason_of(tests::load_blob(*two, digest)), "BLOB_CORRUPT");
    EXPECT_FALSE(two->has_blob(digest));
    ASSERT_TRUE(store_blob(*two, bytes).ok());
    EXPECT_TRUE(two->has_blob(digest));
    EXPECT_EQ(*tests::load_blob(*Process().open(uri()), digest), bytes);
    // Garbage is purged at any time.
    EXPECT_EQ(run("SELECT count(*) FROM content WHERE named = 1"), run("SELECT count(*) FROM blob"))
        << "the damaged one is garbage";
  }
}

TEST_F(CopiedMeshes, OneContentIsNamedWhereSeveralStoreTheSame) {
  const auto one = open();
  const auto two = two_.open(uri());
  for (const std::size_t size : kSizes) {
    for (int i = 0; i < 8; ++i) {
      const std::string bytes = blob_bytes(i, size);
      std::vector<std::unique_ptr<BlobWriter>> writers;
      for (PostgresStore* store : {one.get(), two.get(), one.get()}) {
        auto writing = store->write_blob(digest_of_blob(bytes));
        ASSERT_TRUE(writing);
        ASSERT_TRUE((*writing)->append(as_bytes(bytes)));
        writers.push_back(std::move(*writing));
      }
      {
        std::vector<std::jthread> threads;
        for (const auto& writer : writers)
          threads.emplace_back([&] { EXPECT_TRUE(writer->finish()); });
      }
      EXPECT_EQ(*tests::load_blob(*Process().open(uri()), digest_of_blob(bytes)), bytes);
    }
  }
  EXPECT_EQ(run("SELECT count(*) FROM content WHERE named = 1"), "16");
  EXPECT_EQ(run("SELECT count(*) FROM blob JOIN content ON content = content.id WHERE named = 0"),
            "0");
}

}  // namespace
}  // namespace sightline::server::store::postgres
