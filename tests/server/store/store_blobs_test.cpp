// Blobs of a store of each engine: what is kept over a restart, what is refused, and what is swept.
#include "server/store/store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <thread>

#include "tests/server/store/store_kinds.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::append;
using tests::blob_bytes;
using tests::digest_of_blob;
using tests::make_scene;
using tests::put_snapshot;
using tests::reason_of;
using tests::store_blob;

constexpr std::chrono::seconds kNoGrace{0};

class StoreBlobs : public tests::StoreTest {};

TEST_P(StoreBlobs, KeepsBlobsOverARestart) {
  auto store = open();
  const std::string bytes = blob_bytes(1, 100'000);
  const auto digest = digest_of_blob(bytes);
  EXPECT_FALSE(store->has_blob(digest));
  ASSERT_TRUE(store_blob(*store, bytes).ok());
  EXPECT_TRUE(store->has_blob(digest));
  EXPECT_EQ(reason_of(store->write_blob(digest)), "BLOB_STORED");
  EXPECT_EQ(store->figures().blob_bytes, bytes.size());
  store.reset();
  store = open();
  EXPECT_TRUE(store->has_blob(digest));
  EXPECT_EQ(store->figures().blob_bytes, bytes.size());
  EXPECT_EQ(*tests::load_blob(*store, digest), bytes);
  EXPECT_EQ(reason_of(tests::load_blob(*store, digest_of_blob("x"))), "BLOB_NOT_STORED");
}

TEST_P(StoreBlobs, RefusesBytesThatAreNotThoseOfTheDigest) {
  const auto store = open();
  const std::string bytes = blob_bytes(1);
  std::string wrong = bytes;
  wrong[3] = '!';
  const auto digest = digest_of_blob(bytes);
  {
    const auto writer = std::move(*store->write_blob(digest));
    ASSERT_TRUE(writer->append(std::as_bytes(std::span(wrong))).ok());
    EXPECT_EQ(reason_of(writer->append(std::as_bytes(std::span("x", 1)))), "BLOB_TOO_LONG");
    EXPECT_EQ(reason_of(writer->finish()), "DIGEST_MISMATCH");
  }
  EXPECT_FALSE(store->has_blob(digest));
}

TEST_P(StoreBlobs, TwoWritersOfABlobBothSucceed) {
  const auto store = open();
  const std::string bytes = blob_bytes(1);
  const auto one = std::move(*store->write_blob(digest_of_blob(bytes)));
  const auto two = std::move(*store->write_blob(digest_of_blob(bytes)));
  ASSERT_TRUE(one->append(std::as_bytes(std::span(bytes))).ok());
  ASSERT_TRUE(two->append(std::as_bytes(std::span(bytes))).ok());
  EXPECT_TRUE(one->finish().ok());
  EXPECT_TRUE(two->finish().ok());
  EXPECT_EQ(store->figures().blobs, 1u);
}

TEST_P(StoreBlobs, SweepsBlobsThatNothingNames) {
  const auto store = open();
  std::vector<blobs::BlobDigest> digests;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(store_blob(*store, blob_bytes(i)).ok());
    digests.push_back(digest_of_blob(blob_bytes(i)));
  }
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "u", {digests[0], digests[0]}).ok());
  ASSERT_TRUE(append(*store, scene, 1, "u").ok());
  ASSERT_TRUE(put_snapshot(*store, scene, 1, {"s"}, {digests[0], digests[1]}).ok());
  EXPECT_EQ(*store->sweep(std::chrono::hours(1), {}), 0u);
  const auto swept =
      store->sweep(kNoGrace, [&](const blobs::BlobDigest& digest) { return digest == digests[2]; });
  EXPECT_EQ(*swept, blob_bytes(3).size() + blob_bytes(4).size());
  EXPECT_TRUE(store->has_blob(digests[0]));
  EXPECT_TRUE(store->has_blob(digests[1]));
  EXPECT_TRUE(store->has_blob(digests[2]));
  EXPECT_FALSE(store->has_blob(digests[3]));
  EXPECT_EQ(store->figures().blobs, 3u);
  EXPECT_EQ(reason_of(append(*store, scene, 2, "u", {digests[3]})), "BLOB_NOT_STORED");
}

TEST_P(StoreBlobs, ASweptBlobThatIsMappedStaysReadable) {
  const auto store = open();
  const std::string bytes = blob_bytes(1);
  ASSERT_TRUE(store_blob(*store, bytes).ok());
  const auto mapped = std::move(*store->blob(digest_of_blob(bytes)));
  EXPECT_EQ(*store->sweep(kNoGrace, {}), bytes.size());
  EXPECT_TRUE(std::ranges::equal(mapped->bytes(), std::as_bytes(std::span(bytes))));
}

TEST_P(StoreBlobs, SweepsTheBlobsOfARemovedScene) {
  const auto store = open();
  const std::string bytes = blob_bytes(1);
  ASSERT_TRUE(store_blob(*store, bytes).ok());
  const SceneId scene = make_scene(*store, "a");
  for (std::uint64_t i = 0; i < 600; ++i) {
    const Status queued = store->append({scene,
                                         i,
                                         "u",
                                         {digest_of_blob(bytes)},
                                         RequestAnswer{std::to_string(i), 1, i + 1, {i}},
                                         {{"p", i + 1, {i}}}},
                                        [](const Status& done) { EXPECT_TRUE(done.ok()); });
    ASSERT_TRUE(queued.ok());
  }
  store->flush();
  ASSERT_TRUE(put_snapshot(*store, scene, 600, {"s"}, {digest_of_blob(bytes)}).ok());
  ASSERT_TRUE(store->remove_scene(scene).ok());
  std::uint64_t swept = 0;
  for (int i = 0; i < 1000 && swept == 0; ++i) {
    make_scene(*store, std::to_string(i));  // each commit takes a step
    swept = *store->sweep(kNoGrace, {});
  }
  EXPECT_EQ(swept, bytes.size());
}

RUN_ON_ALL_ENGINES(StoreBlobs);

}  // namespace
}  // namespace sightline::server::store
