// A scene with its recorded properties, history, write queue and events.
#include "server/scenes/stored_scene.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <new>
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

Result<scenegraph::Applied> StoredScene::apply(
    std::vector<scenegraph::model::Update> updates, std::optional<std::uint64_t> expected_revision,
    exec::Compute& compute, const std::function<void(const scenegraph::Applied&)>& record,
    const std::atomic<bool>* cancelled) {
  if (removed()) return removed_error();
  auto before = scene_.snapshot();
  if (const Status good = check_deformed(*before, updates); !good) return good.error();
  auto unsettled = recent_.retain(before);
  std::uint64_t replaced = 0;
  UpdateLog::Entry entry;
  std::vector<RecentRevisions::SnapshotPointer> dropped;
  const auto prepare = [&](const scenegraph::Applied& next) {
    resolve(updates, next.nodes);
    replaced = bytes_replaced(*before, updates);
    if (unsettled != nullptr &&
        unsettled->shared_trees().static_tree != before->shared_trees().static_tree)
      replaced += bytes_of(*unsettled->shared_trees().static_tree);
    entry = log_.prepare(std::move(updates));
    if (record) record(next);
  };
  // Nothing below throws: what is published is in the log.
  auto applied = scene_.apply(updates, expected_revision, prepare, {}, cancelled);
  if (applied) {
    dropped = recent_.account(replaced);
    log_.add(std::move(entry));
    events_.notify();
  }
  settle_later({std::move(dropped), std::move(unsettled), std::move(before)},
               applied && applied->rebuild_static, compute);
  return applied;
}

/// Freeing old revisions and settling may take long, and no reply waits for them.
void StoredScene::settle_later(Dropped dropped, bool settle, exec::Compute& compute) noexcept {
  try {
    compute.enqueue_background(
        [self = shared_from_this(), settle, dropped = std::move(dropped)]() mutable {
          dropped = {};
          if (settle) self->scene_.rebuild_static();
        });
  } catch (const std::bad_alloc&) {  // frees them here; settles after a later update
  }
}

void StoredScene::remove() {
  removed_.store(true, std::memory_order_release);
  events_.notify();
}

Error StoredScene::removed_error() const { return unknown_scene(info_.name); }

void StoredScene::drop_old_revisions() { recent_.drop_all().clear(); }

}  // namespace sightline::server::scenes
