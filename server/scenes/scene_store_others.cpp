// What other servers do to the scenes of a store that they share with this one.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "server/scenes/scene_store.h"

namespace sightline::server::scenes {
namespace {

/// A store that was not heard for longer is not asked by callers: they would wait for nothing.
constexpr std::chrono::seconds kAway{2};

}  // namespace

Status SceneStore::look_up(const std::string& name) {
  if (catalog_ == nullptr || catalog_->replica() == nullptr) return {};
  if (catalog_->replica()->staleness() > kAway) {
    return Error{Code::kUnavailable,
                 fmt::format("whether there is a scene {} is not known while the store is away: "
                             "retry later",
                             name),
                 "STORE_IO"};
  }
  const std::lock_guard changing(changing_);
  return look_up_while_changing(name);
}

Status SceneStore::look_up_while_changing(const std::string& name) {
  if (catalog_ == nullptr || catalog_->replica() == nullptr) return {};
  auto found = catalog_->find(name);
  if (!found) return found.error();
  if (*found) {
    adopt_while_changing(std::move(**found));
  } else if (const auto known = find(name)) {
    forget_while_changing(*known);
  }
  return {};
}

void SceneStore::adopt(SceneCatalog::Found found) {
  const std::lock_guard changing(changing_);
  adopt_while_changing(std::move(found));
}

void SceneStore::adopt_while_changing(SceneCatalog::Found found) {
  const auto known = find(found.info.name);
  if (known && (*known)->number() >= found.kept.number) return;
  spdlog::info("event=scene_found scene={} replaces={}", found.info.name, known.ok());
  publish(std::make_shared<StoredScene>(std::move(found.info), memory_, std::move(found.kept)));
}

void SceneStore::forget(const std::shared_ptr<StoredScene>& scene) {
  const std::lock_guard changing(changing_);
  forget_while_changing(scene);
}

void SceneStore::forget_while_changing(const std::shared_ptr<StoredScene>& scene) {
  {
    const std::lock_guard lock(mutex_);
    const auto known = scenes_.find(scene->info().name);
    if (known == scenes_.end() || known->second != scene) return;
    scenes_.erase(known);
  }
  spdlog::info("event=scene_gone scene={}", scene->info().name);
  scene->remove();
}

std::map<store::SceneId, std::shared_ptr<StoredScene>> SceneStore::by_number() const {
  std::map<store::SceneId, std::shared_ptr<StoredScene>> scenes;
  const std::lock_guard lock(mutex_);
  for (const auto& [name, scene] : scenes_) scenes.emplace(scene->number(), scene);
  return scenes;
}

}  // namespace sightline::server::scenes
