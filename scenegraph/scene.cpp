// Applies a batch of updates: checks and edits a private copy, then publishes it whole.
#include "scenegraph/scene.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "scenegraph/revision/draft.h"
#include "scenegraph/revision/restore.h"

namespace sightline::scenegraph {

Scene::Scene(const revision::MergeRule& rule)
    : merge_state_{rule, 0, 0},
      published_{std::make_shared<const revision::Snapshot>(0, hierarchy::Hierarchy{}), 1} {}

Status Scene::restore(SceneContent content) {
  auto hierarchy = revision::restore_hierarchy(std::move(content.nodes), content.next_id);
  if (!hierarchy) return hierarchy.error();
  const std::lock_guard writer(writer_);
  set_published(
      {std::make_shared<const revision::Snapshot>(content.revision, *hierarchy), content.next_id});
  return {};
}

SceneState Scene::state() const {
  const std::lock_guard lock(published_mutex_);
  return published_;
}

std::shared_ptr<const revision::Snapshot> Scene::head() const {
  const std::lock_guard writer(writer_);
  return newest().snapshot;
}

Result<Applied> Scene::apply(const std::vector<model::Update>& updates,
                             const ApplyOptions& options) {
  std::shared_ptr<const revision::Snapshot> base;  // released outside the lock
  const std::lock_guard writer(writer_);
  const model::NodeId first_id = newest().next_id;
  base = newest().snapshot;
  if (options.expected_revision && *options.expected_revision != base->revision()) {
    return Error{Code::kAborted,
                 "expected revision " + std::to_string(*options.expected_revision) +
                     ", but the scene is at " + std::to_string(base->revision()),
                 "REVISION_MISMATCH"};
  }
  revision::Draft draft(*base, first_id, options.charge, options.cancelled);
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (const Status status = draft.apply(updates[i]); !status) {
      Error error = status.error();
      error.message = "update " + std::to_string(i) + ": " + error.message;
      return error;
    }
  }
  if (const Status status = draft.finish(); !status) return status.error();

  Applied applied{base->revision() + 1, draft.put_nodes()};
  SceneState next{nullptr, draft.next_id()};
  next.snapshot = std::move(draft).publish(merge_state_);
  applied.merge_trees = due_static_merge(*next.snapshot) || due_dynamic_merge(*next.snapshot);
  unpublished_.push_back(std::move(next));
  try {
    if (options.before_publish) options.before_publish(applied);
  } catch (...) {
    unpublished_.pop_back();
    throw;
  }
  if (options.publish) {
    set_published(std::move(unpublished_.back()));
    unpublished_.pop_back();
  }
  return applied;
}

void Scene::publish_next() noexcept {
  const std::lock_guard writer(writer_);
  set_published(std::move(unpublished_.front()));
  unpublished_.pop_front();
}

void Scene::drop_unpublished() noexcept {
  std::deque<SceneState> dropped;  // released outside the lock
  const std::lock_guard writer(writer_);
  dropped.swap(unpublished_);
}

void Scene::set_published(SceneState next) noexcept {
  // The old snapshot is released outside the lock: freeing it may take long.
  const std::lock_guard lock(published_mutex_);
  std::swap(published_, next);
}

/// Replaces the published snapshot and the head by what renew() makes of them. The writer's lock is
/// held.
template <class Renew>
void Scene::renew_trees(const Renew& renew) {
  SceneState now = state();
  now.snapshot = renew(*now.snapshot);
  if (!unpublished_.empty()) unpublished_.back().snapshot = renew(*unpublished_.back().snapshot);
  set_published(std::move(now));
}

/// The static merge that is due. It does not begin while trees are merged that it would hold. The
/// writer's lock is held.
std::optional<revision::LevelRange> Scene::due_static_merge(const revision::Snapshot& now) const {
  if (merge_state_.static_up_to > 0 || merge_state_.dynamic_up_to > 0) return std::nullopt;
  return revision::due_static_merge(now);
}

/// The dynamic merge that is due. The writer's lock is held.
std::optional<revision::LevelRange> Scene::due_dynamic_merge(const revision::Snapshot& now) const {
  if (merge_state_.dynamic_up_to > 0) return std::nullopt;
  return revision::due_dynamic_merge(now, merge_state_);
}

void Scene::merge_trees() {
  merge(static_merging_, merge_state_.static_up_to,
        [this](const revision::Snapshot& now) { return due_static_merge(now); });
  merge(dynamic_merging_, merge_state_.dynamic_up_to,
        [this](const revision::Snapshot& now) { return due_dynamic_merge(now); });
}

/// Merges the trees that due() returns. `up_to`, guarded by the writer's lock, says which trees are
/// being merged.
template <class Due>
void Scene::merge(std::mutex& merging, std::uint64_t& up_to, const Due& due) {
  const std::unique_lock lock(merging, std::try_to_lock);
  if (!lock.owns_lock()) return;
  std::shared_ptr<const revision::Snapshot> base;
  std::optional<revision::LevelRange> range;
  {
    const std::lock_guard writer(writer_);
    base = snapshot();
    if (base->shared_trees().static_tree()->instances_so_far() == nullptr) return;
    range = due(*base);
    if (!range || !has_levels(*newest().snapshot, *base, *range)) return;
    up_to = base->shared_trees().levels[range->end - 1].last;
  }
  std::optional<instances::Level> level;
  try {
    level = merged(*base, *range);
  } catch (const std::bad_alloc&) {  // the trees stay as they are
  }
  const std::lock_guard writer(writer_);
  up_to = 0;
  if (!level || !has_levels(*snapshot(), *base, *range) ||
      !has_levels(*newest().snapshot, *base, *range))
    return;
  renew_trees(
      [&](const revision::Snapshot& now) { return with_merged(now, *base, *range, *level); });
}

std::uint64_t Scene::drop_trees() {
  std::shared_ptr<const revision::Snapshot> now;  // released outside the lock
  {
    const std::lock_guard writer(writer_);
    now = snapshot();
    const std::vector<instances::Level>& levels = now->shared_trees().levels;
    if (std::ranges::any_of(levels, [](const instances::Level& level) {
          return level.tree->instances_so_far() != nullptr;
        })) {
      renew_trees([](const revision::Snapshot& old) {
        return std::make_shared<const revision::Snapshot>(old.revision(), old.hierarchy());
      });
    }
  }
  std::uint64_t bytes = 0;
  for (const model::Mesh* mesh : now->meshes()) bytes += mesh->drop_tree();
  return bytes;
}

}  // namespace sightline::scenegraph
