// Meshes of a store of each engine: they are read when they are needed, and counted while they are
// in memory.
#include <gtest/gtest.h>

#include <filesystem>

#include "server/blobs/blob_store.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/server/store/store_kinds.h"
#include "tests/server/store/store_steps.h"
#include "tests/support/scenes.h"

namespace sightline::server::store {
namespace {

using exec::Held;
using scenegraph::model::Reclaim;

class StoreMeshes : public tests::StoreTest {
 protected:
  const std::string bytes_ = tests::blob_of(tests::icosphere(3));
  const blobs::BlobDigest digest_ = tests::digest_of(bytes_);
};

TEST_P(StoreMeshes, AreInMemoryFromTheirFirstUseOn) {
  const auto store = open();
  exec::MemoryAccount memory(1 << 20);
  blobs::BlobStore blobs(memory, {}, store.get());
  const auto upload = blobs.begin(digest_, 0, {"robot", "robot:1"});
  ASSERT_TRUE(upload);
  ASSERT_TRUE((*upload)->append(0, tests::bytes_of(bytes_)));
  const auto uploaded = blobs.complete(*upload);
  ASSERT_TRUE(uploaded);
  EXPECT_EQ((*uploaded)->triangles(), 1280u);
  EXPECT_FALSE((*uploaded)->is_resident());
  EXPECT_EQ(memory.used(), 0u);
  EXPECT_EQ(*blobs.load(digest_), *uploaded) << "the same one";
  ASSERT_TRUE((*uploaded)->make_resident(Reclaim::kForbidden));
  EXPECT_EQ(memory.used(Held::kMeshes), (*uploaded)->bytes());
  EXPECT_EQ(blobs::digest_of(**uploaded), digest_);
}

TEST_P(StoreMeshes, AreReadOverARestart) {
  auto store = open();
  ASSERT_TRUE(tests::store_blob(*store, bytes_));
  store.reset();
  store = open();
  exec::MemoryAccount memory(1 << 20);
  blobs::BlobStore blobs(memory, {}, store.get());
  auto mesh = *blobs.use(digest_);
  EXPECT_EQ(memory.used(), 0u);
  const auto other = blobs.load_patched(*mesh, digest_);
  ASSERT_TRUE(other);
  EXPECT_TRUE(mesh->is_resident()) << "both have its faces";
  mesh.reset();
  EXPECT_TRUE(blobs.drop_unused_mesh(blobs::Unused::kAny));
  EXPECT_EQ(memory.used(Held::kMeshes), 0u);
}

TEST_P(StoreMeshes, ThatDoNotFitNameTheBudget) {
  const auto store = open();
  ASSERT_TRUE(tests::store_blob(*store, bytes_));
  exec::MemoryAccount memory(bytes_.size());
  blobs::BlobStore blobs(memory, {}, store.get());
  const auto mesh = blobs.use(digest_);
  ASSERT_TRUE(mesh);
  const auto held = memory.record(Held::kNodes, 1000);
  const Status resident = (*mesh)->make_resident(Reclaim::kAllowed);
  ASSERT_FALSE(resident);
  EXPECT_EQ(resident.error().reason, exec::kMemoryBudget);
  EXPECT_FALSE((*mesh)->is_resident());
}

RUN_ON_ALL_ENGINES(StoreMeshes);

}  // namespace
}  // namespace sightline::server::store
