// The catalog of the scenes in a store.
#pragma once

#include <memory>
#include <utility>

#include "server/blobs/blob_store.h"
#include "server/exec/executors.h"
#include "server/scenes/journal.h"
#include "server/store/store.h"

namespace sightline::server::durable {

/// What journals use. Each part outlives every journal.
struct StoreParts {
  store::Store& store;
  blobs::BlobStore& blobs;
  exec::Compute& compute;
};

class StoreCatalog final : public scenes::SceneCatalog {
 public:
  /// `replica`: where other servers use the store, too; else null.
  explicit StoreCatalog(const StoreParts& parts, std::shared_ptr<scenes::Replica> replica = nullptr)
      : parts_(parts), replica_(std::move(replica)) {}

  Result<scenes::KeptScene> create(const scenes::SceneInfo& info) override;
  Result<scenes::KeptScene> restore(const scenes::SceneInfo& info,
                                    const scenegraph::SceneState& state, bool replace) override;
  Result<std::vector<Found>> find_all() override;
  Result<std::optional<Found>> find(const std::string& name) override;
  scenes::Replica* replica() override { return replica_.get(); }

  /// The scene of this id. Errors: kNotFound.
  Result<Found> find(store::SceneId id);

 private:
  Found found(const store::SceneRecord& record) const;

  const StoreParts parts_;
  const std::shared_ptr<scenes::Replica> replica_;
};

}  // namespace sightline::server::durable
