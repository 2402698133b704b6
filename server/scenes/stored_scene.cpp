// A scene with its recorded properties, history, write queue and events.
#include "server/scenes/stored_scene.h"

#include <fmt/format.h>

#include <utility>

#include "server/scenes/applied_updates.h"

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

void SceneEvents::notify() {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, listener] : listeners_) listener();
}

Error unknown_scene(const std::string& name) {
  return {Code::kNotFound, fmt::format("there is no scene {}", name), "SCENE_NOT_FOUND"};
}

Result<std::shared_ptr<const scenegraph::revision::Snapshot>> StoredScene::at(
    std::uint64_t revision) const {
  auto head = scene_.snapshot();
  if (revision == head->revision()) return head;
  if (auto kept = recent_.find(revision)) return kept;
  return Error{Code::kOutOfRange,
               fmt::format("revision {} is not kept; kept are {} to {}", revision,
                           recent_.oldest_or(head->revision()), head->revision()),
               "REVISION_NOT_KEPT"};
}

scenegraph::revision::SceneSummary StoredScene::summary() {
  const auto snapshot = scene_.snapshot();
  {
    const std::lock_guard lock(summary_mutex_);
    if (summarized_revision_ == snapshot->revision()) return summary_;
  }
  const auto summary = scenegraph::revision::summarize(*snapshot);
  const std::lock_guard lock(summary_mutex_);
  summarized_revision_ = summary.revision;
  summary_ = summary;
  return summary;
}

Result<scenegraph::Applied> StoredScene::apply(std::vector<scenegraph::model::Update> updates,
                                               std::optional<std::uint64_t> expected_revision,
                                               exec::Compute& compute) {
  if (removed()) return removed_error();
  std::vector<RecentRevisions::SnapshotPointer> dropped;
  auto before = scene_.snapshot();
  if (const Status good = check_deformed(*before, updates); !good) return good.error();
  auto unsettled = recent_.retain(before);
  auto applied = scene_.apply(updates, expected_revision);
  if (applied) {
    resolve(updates, applied->nodes);
    std::uint64_t replaced = bytes_replaced(*before, updates);
    if (unsettled != nullptr &&
        unsettled->shared_trees().static_tree != before->shared_trees().static_tree)
      replaced += bytes_of(*unsettled->shared_trees().static_tree);
    dropped = recent_.account(replaced);
    log_.add(std::move(updates));
    events_.notify();
  }
  dropped.push_back(std::move(unsettled));
  dropped.push_back(std::move(before));
  // Freeing old revisions and settling may take long, and no reply waits for them.
  compute.enqueue_background([self = shared_from_this(),
                              settle = applied && applied->rebuild_static,
                              dropped = std::move(dropped)]() mutable {
    dropped.clear();
    if (settle) self->scene_.rebuild_static();
  });
  return applied;
}

void StoredScene::remove() {
  removed_.store(true, std::memory_order_release);
  events_.notify();
}

Error StoredScene::removed_error() const { return unknown_scene(info_.name); }

void StoredScene::drop_old_revisions() { recent_.drop_all().clear(); }

}  // namespace sightline::server::scenes
