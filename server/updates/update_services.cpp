// What the calls that change or follow scenes need of the server.
#include "server/updates/update_services.h"

#include "server/scenes/names.h"

namespace sightline::server {

Result<std::shared_ptr<StoredScene>> UpdateServices::find(const std::string& scene) const {
  if (const Status good = check_scene_name(scene); !good) return good.error();
  return scenes.get(scene);
}

}  // namespace sightline::server
