// What a store keeps of scenes, as the parts of a backup.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/store.h"
#include "sightline/v1/backup.pb.h"

namespace sightline::server::durable {

/// Reads scenes one after the other, each as it is committed when its turn comes. Threads: one at a
/// time.
class BackupReader {
 public:
  /// `scene`: only this one; empty: all. `known`: meshes whose bytes are left out. `store` outlives
  /// this object.
  BackupReader(store::Store& store, std::string scene, std::set<blobs::BlobDigest> known)
      : store_(store), only_(std::move(scene)), known_(std::move(known)) {}

  /// Finds the scenes. Errors: kNotFound, as of the store.
  Status begin();
  /// The next part; false after the last. Errors: as of the store.
  Result<bool> next(v1::BackupPart& part);

 private:
  enum class Step : std::uint8_t { kScene, kMeshes, kNodes, kBatches };

  Result<bool> read_step(v1::BackupPart& part);
  Status begin_scene();
  Result<bool> read_mesh(v1::BackupPart& part);
  void describe_scene(v1::BackupPart& part) const;
  Result<bool> read_nodes(v1::BackupPart& part);
  Status read_batch(v1::BackupPart& part);

  store::Store& store_;
  const std::string only_;
  const std::set<blobs::BlobDigest> known_;
  std::vector<store::SceneRecord> scenes_;  // the next one last
  std::set<blobs::BlobDigest> sent_;        // meshes
  Step step_ = Step::kScene;
  // The scene that is read:
  int attempts_ = 0;
  store::SceneRecord scene_;
  std::vector<blobs::BlobDigest> meshes_;  // meshes that are not sent yet
  std::shared_ptr<const store::BlobBytes> mesh_;
  std::uint64_t chunk_ = 0;  // the next chunk of the nodes
  std::deque<store::LoggedBatch> batches_;
  std::uint64_t revision_ = 0;  // the last batch in batches_ or before
  std::size_t offset_ = 0;      // in the mesh or in the first batch
};

}  // namespace sightline::server::durable
