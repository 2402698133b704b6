// Scenes from the parts of a backup.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/scene.h"
#include "server/blobs/blob_store.h"
#include "server/durable/nodes_codec.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/scenes/scene_store.h"
#include "sightline/v1/backup.pb.h"

namespace sightline::server::durable {

/// Puts scenes in the place of those with the same names. Threads: one at a time.
class Restorer {
 public:
  struct Parts {
    scenes::SceneStore& scenes;
    blobs::BlobStore& blobs;
    exec::MemoryAccount& memory;
    exec::Caller caller;  ///< Pays for what is on its way.
  };
  struct Wanted {
    std::string scene = {};      ///< Empty: all.
    std::uint64_t revision = 0;  ///< 0: the newest.
  };
  /// The parts outlive this object.
  Restorer(const Parts& parts, Wanted wanted);
  ~Restorer();
  Restorer(const Restorer&) = delete;
  Restorer& operator=(const Restorer&) = delete;

  /// Takes the next part. What has arrived of a scene counts as an upload of the caller. A scene is
  /// restored when its end arrives. Errors: kInvalidArgument (bad names or parts out of order),
  /// kDataLoss (corrupt parts), kOutOfRange (the backup does not have the revision),
  /// kResourceExhausted (a scene or a batch that is too large for the memory budget), as
  /// SceneStore::restore and Upload.
  Status take(const v1::BackupPart& part);
  /// Call it after the last part. Errors: kDataLoss (it was not the last), kNotFound (the scene is
  /// not in the backup).
  Status finish() const;

  struct Restored {
    std::string scene;
    scenes::RevisionToken revision;
  };
  const std::vector<Restored>& restored() const { return restored_; }

 private:
  /// A scene whose end has not come.
  struct Scene;

  Status take_mesh(const v1::BackupMesh& mesh);
  Status begin_scene(const v1::BackupScene& begun);
  Status take_nodes(Scene& scene, const std::string& nodes);
  Status take_batch(Scene& scene, const v1::BackupBatch& batch);
  Status hold(const Scene& scene, std::uint64_t more);
  Status begin_log(Scene& scene);
  Status apply(Scene& scene, const std::string& updates);
  Status end_scene();

  const Parts parts_;
  const Wanted wanted_;
  std::shared_ptr<blobs::Upload> upload_;  // a mesh that is not whole
  bool in_mesh_ = false;
  bool in_scene_ = false;  // perhaps one that is not wanted
  std::unique_ptr<Scene> scene_;
  std::vector<Restored> restored_;
};

}  // namespace sightline::server::durable
