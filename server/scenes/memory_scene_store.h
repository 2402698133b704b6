// Keeps scenes in memory. They are lost when the process ends.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/scenes/scene_store.h"

namespace sightline::server::scenes {

class MemorySceneStore final : public SceneStore {
 public:
  static constexpr std::size_t kMaxScenes = 10'000;

  Result<std::shared_ptr<StoredScene>> create(SceneInfo info) override;
  Result<std::shared_ptr<StoredScene>> get(const std::string& name) const override;
  ScenePage list(const std::string& project, const std::string& after,
                 std::size_t limit) const override;
  Status remove(const std::string& name) override;
  void drop_old_revisions() override;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<StoredScene>> scenes_;
};

}  // namespace sightline::server::scenes
