// Keeps scenes by name, in memory. They are lost when the process ends.
#include "server/scenes/scene_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace sightline::server::scenes {

Result<std::shared_ptr<StoredScene>> SceneStore::create(SceneInfo info) {
  const std::lock_guard lock(mutex_);
  if (scenes_.contains(info.name)) {
    return Error{Code::kAlreadyExists, fmt::format("scene {} exists already", info.name),
                 "SCENE_EXISTS"};
  }
  if (scenes_.size() >= kMaxScenes) {
    return Error{
        Code::kResourceExhausted,
        fmt::format("the server holds {} scenes, the limit is {}", scenes_.size(), kMaxScenes),
        "TOO_MANY_SCENES"};
  }
  auto scene = std::make_shared<StoredScene>(std::move(info), memory_);
  scenes_.emplace(scene->info().name, scene);
  return scene;
}

Result<std::shared_ptr<StoredScene>> SceneStore::get(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return unknown_scene(name);
  return found->second;
}

ScenePage SceneStore::list(const std::string& project, const std::string& after, std::size_t limit,
                           const Shown& shown) const {
  const std::string prefix = project + "/";
  const std::lock_guard lock(mutex_);
  ScenePage page;
  for (auto it = scenes_.upper_bound(std::max(prefix, after)); it != scenes_.end(); ++it) {
    if (!it->first.starts_with(prefix)) break;
    if (shown && !shown(it->first)) continue;
    if (page.scenes.size() == limit) {
      page.next = page.scenes.back()->info().name;
      break;
    }
    page.scenes.push_back(it->second);
  }
  return page;
}

Status SceneStore::remove(const std::string& name) {
  std::shared_ptr<StoredScene> removed;
  {
    const std::lock_guard lock(mutex_);
    const auto found = scenes_.find(name);
    if (found == scenes_.end()) return unknown_scene(name);
    removed = std::move(found->second);
    scenes_.erase(found);
  }
  removed->remove();
  return {};  // `removed` may free large trees, outside the lock
}

std::vector<std::shared_ptr<StoredScene>> SceneStore::by_last_cast() const {
  using Dated = std::pair<StoredScene::Clock::time_point, std::shared_ptr<StoredScene>>;
  std::vector<Dated> dated;
  {
    const std::lock_guard lock(mutex_);
    dated.reserve(scenes_.size());
    for (const auto& [name, scene] : scenes_) dated.emplace_back(scene->last_cast(), scene);
  }
  std::ranges::sort(dated, {}, &Dated::first);
  std::vector<std::shared_ptr<StoredScene>> scenes;
  scenes.reserve(dated.size());
  for (auto& [when, scene] : dated) scenes.push_back(std::move(scene));
  return scenes;
}

}  // namespace sightline::server::scenes
