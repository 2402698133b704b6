// The directories of copies of meshes: each belongs to one server, also while others come and go.
#include "server/store/postgres/mesh_cache.h"

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/store/store_steps.h"

namespace sightline::server::store::postgres {
namespace {

using tests::blob_bytes;
using tests::digest_of_blob;

/// Opens a cache, keeps a blob in it, and finds it.
::testing::AssertionResult use_once(FileSystem& files, const std::string& bytes) {
  auto cache = MeshCache::open(files, {}, {});
  if (!cache) return ::testing::AssertionFailure() << cache.error().message;
  auto copy = (*cache)->create(bytes.size());
  if (!copy) return ::testing::AssertionFailure() << copy.error().message;
  if (const Status added = (*copy)->append(std::as_bytes(std::span(bytes))); !added)
    return ::testing::AssertionFailure() << added.error().message;
  if (const auto kept = (*copy)->keep(digest_of_blob(bytes)); !kept)
    return ::testing::AssertionFailure() << kept.error().message;
  if ((*cache)->find(digest_of_blob(bytes)) == nullptr)
    return ::testing::AssertionFailure() << "what was kept is not found";
  return ::testing::AssertionSuccess();
}

TEST(MeshCaches, ThatComeAndGoShareNoDirectory) {
  FileSystem& files = local_files();
  std::vector<std::thread> servers;
  for (int i = 0; i < 4; ++i) {
    servers.emplace_back([&files, bytes = blob_bytes(i)] {
      for (int round = 0; round < 20; ++round) EXPECT_TRUE(use_once(files, bytes));
    });
  }
  for (std::thread& server : servers) server.join();
}

}  // namespace
}  // namespace sightline::server::store::postgres
