// Steps that tests of a store share.
#include "tests/server/store/store_steps.h"

#include <gtest/gtest.h>

#include <future>
#include <utility>

#include "tests/server/blobs/blob_of.h"

namespace sightline::tests {

using server::blobs::BlobDigest;
using server::store::Batch;
using server::store::SceneId;
using server::store::Store;

std::string blob_bytes(int number, std::size_t size) {
  std::string bytes = std::to_string(number) + ":";
  while (bytes.size() < size) bytes += static_cast<char>('a' + bytes.size() % 26);
  return bytes;
}

BlobDigest digest_of_blob(const std::string& bytes) {
  server::blobs::Sha256 sum;
  sum.update(bytes_of(bytes));
  return {sum.finish(), bytes.size()};
}

Status store_blob(Store& store, const std::string& bytes) {
  auto writer = store.write_blob(digest_of_blob(bytes));
  if (!writer) return writer.error();
  const std::size_t half = bytes.size() / 2;
  Status done = (*writer)->append(bytes_of(bytes).first(half));
  if (done) done = (*writer)->append(bytes_of(bytes).subspan(half));
  if (done) done = (*writer)->finish();
  return done;
}

Result<std::string> load_blob(Store& store, const BlobDigest& digest) {
  const auto blob = store.blob(digest);
  if (!blob) return blob.error();
  const auto bytes = (*blob)->bytes();
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Status append(Store& store, Batch batch) {
  const auto outcome = std::make_shared<std::promise<Status>>();
  Status queued = store.append(
      std::move(batch), [outcome](const Status& committed) { outcome->set_value(committed); });
  if (!queued) return queued;
  return outcome->get_future().get();
}

Status append(Store& store, SceneId scene, std::uint64_t expected, const std::string& updates,
              const std::vector<BlobDigest>& blobs) {
  Batch batch;
  batch.scene = scene;
  batch.expected = expected;
  batch.updates = updates;
  batch.blobs = blobs;
  return append(store, std::move(batch));
}

SceneId make_scene(Store& store, const std::string& name) {
  const auto made = store.create_scene({.name = name, .incarnation = 7});
  EXPECT_TRUE(made.ok()) << made.error().message;
  return made ? *made : 0;
}

Result<std::vector<std::string>> log_of(Store& store, SceneId scene, std::uint64_t after) {
  std::vector<std::string> all;
  for (;;) {
    const auto part = store.read(scene, after + all.size(), 1000);
    if (!part) return part.error();
    if (part->empty()) return all;
    for (const auto& batch : *part) {
      EXPECT_EQ(batch.revision, after + all.size() + 1);
      all.push_back(batch.updates);
    }
  }
}

Status put_snapshot(Store& store, SceneId scene, std::uint64_t revision,
                    std::vector<std::string> chunks, const std::vector<BlobDigest>& blobs) {
  std::size_t next = 0;
  return store.put_snapshot(scene, revision, blobs, [&]() -> Result<std::string> {
    return next < chunks.size() ? chunks[next++] : std::string();
  });
}

server::store::StoreLimits small_disk() {
  server::store::StoreLimits limits;
  limits.min_free_disk = 0;
  return limits;
}

std::unique_ptr<server::store::SqliteStore> open_store(const std::filesystem::path& directory,
                                                       server::store::FileSystem& files) {
  auto store = server::store::SqliteStore::open(directory, small_disk(), files);
  EXPECT_TRUE(store.ok()) << store.error().message;
  return store ? std::move(*store) : nullptr;
}

}  // namespace sightline::tests
