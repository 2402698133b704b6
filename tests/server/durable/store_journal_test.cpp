// Scenes in a store: what is written is read again, whole.
#include "server/durable/store_journal.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <optional>

#include "scenegraph/scene.h"
#include "server/durable/batch_codec.h"
#include "server/durable/nodes_codec.h"
#include "tests/server/durable/life.h"

namespace sightline::server::durable {
namespace {

namespace fs = std::filesystem;
using scenegraph::model::Update;

using StoreJournalTest = tests::DurableTest;

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
  apply({put(cube), scenegraph::model::PatchVertices{{2}, 0, {{9, 9, 9}}}},
        {.request_id = "x", .content = 3});
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

TEST_F(StoreJournalTest, LabelsAreKeptInTheLogAndInTheNodes) {
  using scenegraph::model::Label;
  const auto labelled = [](scenegraph::model::NodeRef ref, const std::string& storey) {
    scenegraph::model::PutNode node;
    node.node = ref;
    node.labels = std::make_shared<const std::vector<Label>>(
        std::vector<Label>{{"class", "IfcWindow"}, {"storey", storey}});
    return node;
  };
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  apply({labelled(-1, "1")});
  apply({labelled(1, "2")});
  restart();
  const std::vector<Label> newest{{"class", "IfcWindow"}, {"storey", "2"}};
  EXPECT_EQ(*scene()->snapshot()->find(1)->labels, newest);
  EXPECT_EQ((*(*scene()->at(1))->find(1)->labels)[1].value, "1");
  NodesWriter writer({.snapshot = scene()->snapshot(), .next_id = 2});
  NodesReader reader(life_->blobs);
  for (std::string part = writer.next(kPartBytes); !part.empty(); part = writer.next(kPartBytes))
    ASSERT_TRUE(reader.add(part));
  EXPECT_EQ(*std::move(reader).finish(2).nodes.front().labels, newest);
}

TEST_F(StoreJournalTest, NodesAreWrittenDownAndTheLogIsCut) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  const std::string digest = add_mesh(tests::planar_sheet(60));
  apply({put(digest)});
  for (int i = 0; i < 300; ++i) {
    const auto z = static_cast<float>(i);
    apply({scenegraph::model::PatchVertices{
        {1}, 0, std::vector<accel::geometry::Vec3f>(3000, {0, 0, z})}});
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
  EXPECT_EQ(
      std::get<scenegraph::model::SetTransforms>(decoded->updates[1]).parent_from_local[1].m[3],
      0.1);
}

}  // namespace
}  // namespace sightline::server::durable
