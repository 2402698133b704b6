// Scenes in a store: what is written is read again, whole.
#include "server/durable/store_journal.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <future>
#include <optional>

#include "scenegraph/scene.h"
#include "server/durable/batch_codec.h"
#include "server/durable/open_store.h"
#include "server/scenes/scene_store.h"
#include "tests/scenegraph/put_node.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/support/scenes.h"

namespace sightline::server::durable {
namespace {

namespace fs = std::filesystem;
using scenegraph::model::Update;

const std::string kName = "projects/p/scenes/s";

/// What a server has between its start and its end.
struct Life {
  explicit Life(const fs::path& directory)
      : store(*open_store(directory)),
        blobs(memory, {}, store.get()),
        keeper({*store, blobs, compute}),
        scenes(memory, &keeper) {
    EXPECT_TRUE(scenes.open());
  }
  ~Life() { store->flush(); }

  exec::MemoryAccount memory{std::uint64_t{1} << 30};
  std::unique_ptr<store::Store> store;
  blobs::BlobStore blobs;
  exec::Compute compute{2};
  StoreKeeper keeper;
  scenes::SceneStore scenes;
};

class StoreJournalTest : public testing::Test {
 protected:
  StoreJournalTest() {
    std::string pattern = (fs::temp_directory_path() / "sightline-journal-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    life_.emplace(root_ / "data");
  }
  ~StoreJournalTest() override {
    life_.reset();
    fs::remove_all(root_);
  }

  void restart() {
    life_.reset();
    life_.emplace(root_ / "data");
  }
  std::shared_ptr<scenes::StoredScene> scene() {
    const auto found = life_->scenes.get(kName);
    EXPECT_TRUE(found);
    const Status loaded = (*found)->load(life_->compute);
    EXPECT_TRUE(loaded) << loaded.error().message;
    return *found;
  }
  /// The digest of a mesh that is stored.
  std::string add_mesh(const tests::TestMesh& mesh) {
    const std::string blob = tests::blob_of(mesh);
    const auto digest = tests::digest_of(blob);
    const auto upload = life_->blobs.begin(digest, 0);
    EXPECT_TRUE((*upload)->append(0, tests::bytes_of(blob)));
    EXPECT_TRUE(life_->blobs.complete(*upload));
    return digest.text();
  }
  Update put(const std::string& digest) {
    scenegraph::model::PutNode node;
    node.node = -1;
    node.name = "of " + digest;
    node.mesh = *life_->blobs.load(*blobs::BlobDigest::parse(digest));
    node.mesh_digest = digest;
    return node;
  }
  /// Applies a batch and waits until it is kept.
  void apply(std::vector<Update> updates, scenes::SceneWrite write = {}) {
    std::promise<bool> kept;
    write.answer = [&](const Result<scenes::Durability>& result) {
      kept.set_value(result && *result == scenes::Durability::kCommitted);
    };
    const auto stored = scene();
    stored->write_queue().post(life_->compute, [&] {
      const auto applied = stored->apply(std::move(updates), life_->compute, {}, write);
      if (!applied) kept.set_value(false);
    });
    EXPECT_TRUE(kept.get_future().get());
  }

  fs::path root_;
  std::optional<Life> life_;
};

TEST_F(StoreJournalTest, AScenesPropertiesAreKept) {
  const auto made =
      *life_->scenes.create({.name = kName, .up_axis = scenes::UpAxis::kZ, .meters_per_unit = 0.5});
  const std::string token = made->token(0).text();
  restart();
  EXPECT_EQ(scene()->info().up_axis, scenes::UpAxis::kZ);
  EXPECT_EQ(scene()->info().meters_per_unit, 0.5);
  EXPECT_EQ(scene()->token(0).text(), token);
  EXPECT_EQ(life_->scenes.create({.name = kName}).error().code, Code::kAlreadyExists);
  ASSERT_TRUE(life_->scenes.remove(kName));
  restart();
  EXPECT_FALSE(life_->scenes.get(kName));
}

TEST_F(StoreJournalTest, BatchesAndMeshesAreKept) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  const std::string cube = add_mesh(tests::cube());
  apply({put(cube)});
  apply({put(cube), scenegraph::model::PatchVertices{{2}, 0, {{9, 9, 9}}}}, {.request_id = "x", .content = 3});
  restart();
  const auto loaded = scene();
  EXPECT_EQ(loaded->snapshot()->revision(), 2u);
  const auto* first = loaded->snapshot()->find(1);
  const auto* second = loaded->snapshot()->find(2);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(first->mesh->faces(), 12u);
  EXPECT_FALSE(first->patched);
  EXPECT_TRUE(second->patched);
  EXPECT_EQ(second->mesh->view().vertices[0], (accel::geometry::Vec3f{9, 9, 9}));
  EXPECT_EQ((*loaded->at(1))->node_count(), 1u);
  std::promise<std::optional<scenegraph::Applied>> earlier;
  loaded->write_queue().post(life_->compute, [&] {
    std::optional<scenegraph::Applied> found;
    static_cast<void>(loaded->find_earlier(
        "x", 3, [&](const scenegraph::Applied& applied, const auto&) { found = applied; }));
    earlier.set_value(found);
  });
  const auto found = earlier.get_future().get();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->revision, 2u);
  EXPECT_EQ(found->nodes, (std::vector<scenegraph::model::NodeId>{2}));
}

TEST_F(StoreJournalTest, NodesAreWrittenDownAndTheLogIsCut) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  const std::string digest = add_mesh(tests::planar_sheet(60));
  apply({put(digest)});
  for (int i = 0; i < 300; ++i) {
    const auto z = static_cast<float>(i);
    apply({scenegraph::model::PatchVertices{{1}, 0, std::vector<accel::geometry::Vec3f>(3000, {0, 0, z})}});
  }
  life_->store->flush();
  restart();
  const auto record = life_->store->scenes()->front();
  EXPECT_GT(record.base, 0u) << "the log has some MB, the nodes a few KB";
  const auto loaded = scene();
  EXPECT_EQ(loaded->snapshot()->revision(), 301u);
  EXPECT_EQ(loaded->snapshot()->find(1)->mesh->view().vertices[7],
            (accel::geometry::Vec3f{0, 0, 299}));
  EXPECT_TRUE(loaded->snapshot()->find(1)->patched);
  EXPECT_EQ(loaded->snapshot()->find(1)->mesh_digest, digest);
  apply({put(digest)});
  EXPECT_EQ(scene()->snapshot()->node_count(), 2u);
}

TEST_F(StoreJournalTest, ACorruptMeshFailsItsSceneOnly) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  ASSERT_TRUE(life_->scenes.create({.name = "projects/p/scenes/sound"}));
  apply({put(add_mesh(tests::cube()))});
  life_.reset();
  for (const auto& file : fs::recursive_directory_iterator(root_ / "data" / "blobs")) {
    if (file.is_regular_file()) fs::resize_file(file, fs::file_size(file) - 4);
  }
  life_.emplace(root_ / "data");
  const auto found = life_->scenes.get(kName);
  const Status loaded = (*found)->load(life_->compute);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, Code::kDataLoss);
  const auto sound = life_->scenes.get("projects/p/scenes/sound");
  EXPECT_TRUE((*sound)->load(life_->compute));
  EXPECT_FALSE((*life_->scenes.get(kName))->load(life_->compute)) << "it is tried again";
}

TEST(BatchCodec, RefusesOtherBytes) {
  exec::MemoryAccount memory(1 << 20);
  blobs::BlobStore blobs(memory);
  EXPECT_EQ(decode_batch("\xff\xff no batch", blobs).error().code, Code::kDataLoss);
  const std::vector<Update> updates{
      scenegraph::model::DeleteNode{5, true},
      scenegraph::model::SetTransforms{{1, 2}, {{}, scenegraph::model::Affine{{1, 0, 0, 0.1}}}}};
  const auto decoded = decode_batch(encode_batch(updates, {7, 8}), blobs);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->nodes, (std::vector<scenegraph::model::NodeId>{7, 8}));
  EXPECT_EQ(std::get<scenegraph::model::DeleteNode>(decoded->updates[0]).node, 5);
  EXPECT_EQ(std::get<scenegraph::model::SetTransforms>(decoded->updates[1]).parent_from_local[1].m[3],
            0.1);
}

}  // namespace
}  // namespace sightline::server::durable
