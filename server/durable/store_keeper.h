// Keeps scenes in a store.
#pragma once

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

class StoreKeeper final : public scenes::SceneKeeper {
 public:
  explicit StoreKeeper(const StoreParts& parts) : parts_(parts) {}

  Result<scenes::KeptScene> create(const scenes::SceneInfo& info) override;
  Result<scenes::KeptScene> restore(const scenes::SceneInfo& info,
                                    const scenegraph::SceneState& state) override;
  Result<std::vector<Found>> find_all() override;

 private:
  const StoreParts parts_;
};

}  // namespace sightline::server::durable
