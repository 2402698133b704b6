// What a server has of scenes in a store, between its start and its end.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/durable/open_store.h"
#include "server/durable/store_catalog.h"
#include "server/scenes/scene_store.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

struct Life {
  explicit Life(const std::filesystem::path& directory)
      : store(*server::durable::open_store({.directory = directory})),
        blobs(memory, {}, store.get()),
        catalog({*store, blobs, compute}),
        scenes(memory, &catalog) {
    EXPECT_TRUE(scenes.open());
  }
  ~Life() { store->flush(); }

  server::exec::MemoryAccount memory{std::uint64_t{1} << 30};
  std::unique_ptr<server::store::Store> store;
  server::blobs::BlobStore blobs;
  server::exec::Compute compute{2};
  server::durable::StoreCatalog catalog;
  server::scenes::SceneStore scenes;
};

/// A life in a temporary directory, and a scene's name.
class DurableTest : public testing::Test {
 protected:
  const std::string kName = "projects/p/scenes/s";

  DurableTest() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "sightline-durable-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    life_.emplace(root_ / "data");
  }
  ~DurableTest() override {
    life_.reset();
    std::filesystem::remove_all(root_);
  }

  void restart() {
    life_.reset();
    life_.emplace(root_ / "data");
  }
  /// The scene, loaded.
  std::shared_ptr<server::scenes::StoredScene> scene() {
    const auto found = life_->scenes.get(kName);
    EXPECT_TRUE(found);
    const Status loaded = (*found)->load(life_->compute);
    EXPECT_TRUE(loaded) << loaded.error().message;
    return *found;
  }
  std::string add_mesh(const TestMesh& mesh) {
    const std::string blob = blob_of(mesh);
    const auto digest = digest_of(blob);
    const auto upload = life_->blobs.begin(digest, 0, {"robot", "robot:1"});
    EXPECT_TRUE((*upload)->append(0, bytes_of(blob)));
    EXPECT_TRUE(life_->blobs.complete(*upload));
    return digest.text();
  }
  scenegraph::model::Update put(const std::string& digest) {
    scenegraph::model::PutNode node;
    node.node = -1;
    node.name = "of " + digest;
    node.mesh = *life_->blobs.load(*server::blobs::BlobDigest::parse(digest));
    node.mesh_digest = digest;
    return node;
  }
  /// Applies a batch and waits until it is kept.
  void apply(std::vector<scenegraph::model::Update> updates,
             server::scenes::SceneWrite write = {}) {
    std::promise<bool> kept;
    write.answer = [&](const Result<server::scenes::Durability>& result) {
      kept.set_value(result && *result == server::scenes::Durability::kCommitted);
    };
    const auto stored = scene();
    stored->write_queue().post(life_->compute, [&] {
      const auto applied = stored->apply(std::move(updates), life_->compute, {}, write);
      if (!applied) kept.set_value(false);
    });
    EXPECT_TRUE(kept.get_future().get());
  }

  std::filesystem::path root_;
  std::optional<Life> life_;
};

}  // namespace sightline::tests
