// Where scenes are kept. Implementations decide whether they outlive the process.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "accel/result.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {

struct ScenePage {
  std::vector<std::shared_ptr<StoredScene>> scenes;  ///< By name.
  std::string next;  ///< The last name of this page if more follow, else empty.
};

/// Names are checked by the caller (server/scenes/names.h). Threads: any, for every member. A
/// pointer to a scene keeps it alive after its removal.
class SceneStore {
 public:
  virtual ~SceneStore() = default;

  /// Errors: kAlreadyExists, kResourceExhausted (too many scenes).
  virtual Result<std::shared_ptr<StoredScene>> create(SceneInfo info) = 0;
  /// Errors: kNotFound.
  virtual Result<std::shared_ptr<StoredScene>> get(const std::string& name) const = 0;
  /// Up to `limit` scenes of "projects/{project}" whose names come after `after` (empty: from the
  /// first).
  virtual ScenePage list(const std::string& project, const std::string& after,
                         std::size_t limit) const = 0;
  /// Calls the listeners of the scene. Errors: kNotFound.
  virtual Status remove(const std::string& name) = 0;

  /// Drops all revisions except the newest of every scene, and with them the meshes that only they
  /// use. May take long.
  virtual void drop_old_revisions() = 0;
};

}  // namespace sightline::server::scenes
