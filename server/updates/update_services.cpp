// What the calls that change or follow scenes need of the server.
#include "server/updates/update_services.h"

#include "server/scenes/names.h"

namespace sightline::server::updates {

Result<std::shared_ptr<scenes::StoredScene>> UpdateServices::find(const std::string& scene) const {
  if (const Status good = scenes::check_scene_name(scene); !good) return good.error();
  return scenes.get(scene);
}

}  // namespace sightline::server::updates
