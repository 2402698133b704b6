// The scenes of the server by name.
#include "server/scenes/scene_store.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <utility>
#include <vector>

#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {

Status SceneStore::open() {
  if (catalog_ == nullptr) return {};
  auto found = catalog_->find_all();
  if (!found) return found.error();
  const std::lock_guard lock(mutex_);
  for (SceneCatalog::Found& scene : *found) {
    const std::string name = scene.info.name;
    scenes_.emplace(
        name, std::make_shared<StoredScene>(std::move(scene.info), memory_, std::move(scene.kept)));
  }
  return {};
}

Result<std::shared_ptr<StoredScene>> SceneStore::create(SceneInfo info) {
  if (const Status fits = memory_.reclaim(exec::Held::kNodes, bytes_of_scene(0, 0)); !fits)
    return fits.error();
  const std::lock_guard changing(changing_);
  if (const Status known = look_up_while_changing(info.name); !known) return known.error();
  if (const Status good = check_put(info.name, false); !good) return good.error();
  KeptScene kept;
  if (catalog_ != nullptr) {
    auto created = catalog_->create(info);
    if (!created) return created.error();
    kept = std::move(*created);
  }
  auto scene = std::make_shared<StoredScene>(std::move(info), memory_, std::move(kept));
  const std::lock_guard lock(mutex_);
  scenes_.emplace(scene->info().name, scene);
  return scene;
}

Status SceneStore::check_put(const std::string& name, bool replace) const {
  if (!find(name)) return check_number();
  if (replace) return {};
  return Error{Code::kAlreadyExists, fmt::format("scene {} exists already", name), "SCENE_EXISTS"};
}

Status SceneStore::check_number() const {
  const std::lock_guard lock(mutex_);
  if (scenes_.size() < kMaxScenes) return {};
  return Error{
      Code::kResourceExhausted,
      fmt::format("the server holds {} scenes, the limit is {}", scenes_.size(), kMaxScenes),
      "TOO_MANY_SCENES"};
}

Result<std::shared_ptr<StoredScene>> SceneStore::restore(const SceneInfo& info,
                                                         const scenegraph::SceneState& state) {
  if (catalog_ == nullptr)
    return Error{Code::kFailedPrecondition, "the server keeps scenes in memory only",
                 "NOT_DURABLE"};
  const std::lock_guard changing(changing_);
  if (const Status fits = check_put(info.name, true); !fits) return fits.error();
  auto kept = catalog_->restore(info, state, true);
  if (!kept) return kept.error();
  auto scene = std::make_shared<StoredScene>(info, memory_, std::move(*kept));
  publish(scene);
  return scene;
}

Result<std::shared_ptr<StoredScene>> SceneStore::put(const std::shared_ptr<StoredScene>& draft,
                                                     bool replace) {
  const std::lock_guard changing(changing_);
  if (const Status known = look_up_while_changing(draft->info().name); !known) return known.error();
  if (const Status fits = check_put(draft->info().name, replace); !fits) return fits.error();
  auto scene = draft;
  if (catalog_ != nullptr) {
    auto kept = catalog_->restore(draft->info(), draft->state(), replace);
    if (!kept) return kept.error();
    scene = std::make_shared<StoredScene>(draft->info(), memory_, std::move(*kept));
  }
  publish(scene);
  return scene;
}

/// Puts the scene in place of the one of its name, if there is one.
void SceneStore::publish(const std::shared_ptr<StoredScene>& scene) {
  std::shared_ptr<StoredScene> before = scene;
  {
    const std::lock_guard lock(mutex_);
    std::swap(scenes_[scene->info().name], before);
  }
  if (before != nullptr) before->remove();
}

Result<std::shared_ptr<StoredScene>> SceneStore::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return unknown_scene(name);
  return found->second;
}

Result<std::shared_ptr<StoredScene>> SceneStore::get(const std::string& name) {
  auto scene = find(name);
  // A scene that is not loaded was not followed: another server may have made another in its place.
  if (!scene || (*scene)->removed() || !(*scene)->loaded()) {
    if (const Status known = look_up(name); !known) return known.error();
    scene = find(name);
  }
  if (!scene || !(*scene)->failed()) return scene;
  // What could not be read may be readable now; what was read of it is dropped.
  KeptScene kept = (*scene)->kept();
  assert(kept.unread);
  auto fresh = std::make_shared<StoredScene>((*scene)->info(), memory_, std::move(kept));
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return unknown_scene(name);
  if (found->second == *scene) found->second = std::move(fresh);
  return found->second;
}

ScenePage SceneStore::list(const std::string& project, const std::string& after, std::size_t limit,
                           const Shown& shown) const {
  const std::string prefix = project == kAllProjects ? "projects/" : project + "/";
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
  const std::lock_guard changing(changing_);
  if (Status known = look_up_while_changing(name); !known) return known;
  const auto removed = find(name);
  if (!removed) return removed.error();
  if ((*removed)->is_kept()) {
    if (Status dropped = (*removed)->journal()->remove(); !dropped) return dropped;
  }
  {
    const std::lock_guard lock(mutex_);
    scenes_.erase(name);
  }
  (*removed)->remove();
  return {};  // `removed` may free large trees, outside the lock
}

bool SceneStore::unload_one(const std::function<bool(const StoredScene&)>& stays) {
  std::shared_ptr<StoredScene> unloaded;  // its snapshot is freed outside the lock
  const std::lock_guard lock(mutex_);
  std::shared_ptr<StoredScene>* oldest = nullptr;
  for (auto& [name, scene] : scenes_) {
    const std::shared_ptr<StoredScene> looked_at = scene;  // sees what its last user has written
    if (scene.use_count() > 2 || !scene->is_idle() || (stays && stays(*scene))) continue;
    if (oldest == nullptr || scene->last_cast() < (*oldest)->last_cast()) oldest = &scene;
  }
  if (oldest == nullptr) return false;
  KeptScene kept = (*oldest)->kept();
  kept.unread = (*oldest)->snapshot()->revision();
  unloaded = std::make_shared<StoredScene>((*oldest)->info(), memory_, std::move(kept));
  unloaded.swap(*oldest);
  ++unloaded_;
  spdlog::info("event=scene_unloaded scene={}", unloaded->info().name);
  return true;
}

void SceneStore::retry_writes() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, scene] : scenes_) scene->retry_writes();
}

void SceneStore::flush(StoredScene::Clock::time_point until) const {
  for (const auto& scene : by_last_cast()) scene->flush(until);
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
