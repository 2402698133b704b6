// Keeps scenes by name, in memory. They are lost when the process ends.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "accel/result.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {

/// A part of a list of scenes.
struct ScenePage {
  std::vector<std::shared_ptr<StoredScene>> scenes;  ///< By name.
  std::string next;  ///< The last name of this page if more follow, else empty.
};

/// The caller checks names (server/scenes/names.h). Threads: any, for every member. A
/// pointer to a scene keeps it alive after its removal.
class SceneStore {
 public:
  static constexpr std::size_t kMaxScenes = 10'000;

  /// Scenes are charged to `memory`, which outlives them.
  explicit SceneStore(exec::MemoryAccount& memory) : memory_(memory) {}

  /// Errors: kAlreadyExists, kResourceExhausted (too many scenes).
  Result<std::shared_ptr<StoredScene>> create(SceneInfo info);
  /// Errors: kNotFound.
  Result<std::shared_ptr<StoredScene>> get(const std::string& name) const;
  /// Whether a list shows the scene of this name. Must be short and call no member of the store.
  using Shown = std::function<bool(const std::string& name)>;
  /// Up to `limit` scenes of "projects/{project}" whose names come after `after` (empty: from the
  /// first) and that are shown; without `shown` all are.
  ScenePage list(const std::string& project, const std::string& after, std::size_t limit,
                 const Shown& shown = {}) const;
  /// Calls the listeners of the scene. Errors: kNotFound.
  Status remove(const std::string& name);

  /// All scenes, those first at which rays were cast longest ago.
  std::vector<std::shared_ptr<StoredScene>> by_last_cast() const;

 private:
  exec::MemoryAccount& memory_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<StoredScene>> scenes_;
};

}  // namespace sightline::server::scenes
