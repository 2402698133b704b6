// The parts of the server that queries and updates use.
#include "server/scenes/services.h"

#include "server/scenes/names.h"

namespace sightline::server::scenes {

Result<std::shared_ptr<StoredScene>> Services::find(const std::string& scene) const {
  if (const Status good = check_scene_name(scene); !good) return good.error();
  return scenes.get(scene);
}

}  // namespace sightline::server::scenes
