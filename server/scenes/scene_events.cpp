// Listeners of one scene.
#include "server/scenes/scene_events.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

namespace sightline::server::scenes {

std::uint64_t SceneEvents::subscribe(Listener listener) {
  const std::lock_guard lock(mutex_);
  listeners_.emplace(next_, std::move(listener));
  return next_++;
}

void SceneEvents::unsubscribe(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  listeners_.erase(id);
}

void SceneEvents::notify() noexcept {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, listener] : listeners_) {
    try {
      listener();
    } catch (const std::exception& thrown) {
      spdlog::error("event=listener_failed error={}", thrown.what());
    }
  }
}

}  // namespace sightline::server::scenes
