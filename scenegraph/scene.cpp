// Applying a batch of updates: check and edit a private copy, then publish it whole.
#include "scenegraph/scene.h"

#include <new>
#include <utility>

#include "scenegraph/instances/prebuild.h"
#include "scenegraph/revision/draft.h"
#include "scenegraph/revision/restore.h"

namespace sightline::scenegraph {

namespace {

/// A static tree without recently changed nodes, built where rays have been. Null if no ray has
/// opened the old one, or without memory for it.
std::shared_ptr<const instances::SceneTree> rebuild_static_tree(
    const revision::Snapshot& base, const std::vector<model::NodeId>& recently_changed) {
  const instances::Instances* old = base.shared_trees().static_tree->instances_so_far();
  if (old == nullptr) return nullptr;
  try {
    hierarchy::Hierarchy hierarchy = base.hierarchy();
    hierarchy.dynamic_roots = revision::topmost_of(hierarchy, recently_changed);
    auto new_static = std::make_shared<const instances::SceneTree>(instances::MobilitySide::kStatic,
                                                                   std::move(hierarchy));
    prebuild_like(*old, new_static->instances());
    return new_static;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

Scene::Scene()
    : published_{std::make_shared<const revision::Snapshot>(0, hierarchy::Hierarchy{}), 1} {}

Status Scene::restore(SceneContent content) {
  auto hierarchy = revision::restore_hierarchy(std::move(content.nodes), content.next_id);
  if (!hierarchy) return hierarchy.error();
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
  std::vector<model::NodeId> changed = draft.changed();
  next.snapshot = std::move(draft).publish(applied.revision);
  applied.rebuild_static = settle_policy_.add(*next.snapshot, std::move(changed));
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

/// Replaces the published snapshot and the head by what renew() makes of them. With the writer's
/// lock.
template <class Renew>
void Scene::renew_trees(const Renew& renew) {
  SceneState now = state();
  now.snapshot = renew(*now.snapshot);
  if (!unpublished_.empty()) unpublished_.back().snapshot = renew(*unpublished_.back().snapshot);
  set_published(std::move(now));
}

void Scene::rebuild_static() {
  const std::unique_lock rebuild(rebuilding_, std::try_to_lock);
  if (!rebuild.owns_lock()) return;
  std::shared_ptr<const revision::Snapshot> base;
  std::vector<model::NodeId> recently_changed;
  {
    const std::lock_guard writer(writer_);
    base = snapshot();
    recently_changed = settle_policy_.begin(base->revision());
  }
  const std::shared_ptr<const instances::SceneTree> new_static =
      rebuild_static_tree(*base, recently_changed);
  const std::lock_guard writer(writer_);
  const std::vector<model::NodeId> changed = settle_policy_.end(base->revision());
  // Changes are recorded as long as the tree is the one that rays have opened.
  const auto has_old_tree = [&](const revision::Snapshot& now) {
    return now.shared_trees().static_tree == base->shared_trees().static_tree;
  };
  if (new_static == nullptr || !has_old_tree(*snapshot()) || !has_old_tree(*newest().snapshot))
    return;
  renew_trees([&](const revision::Snapshot& now) {
    return with_new_static(now, new_static, recently_changed, changed);
  });
}

std::uint64_t Scene::drop_trees() {
  std::shared_ptr<const revision::Snapshot> now;  // released outside the lock
  {
    const std::lock_guard writer(writer_);
    now = snapshot();
    const instances::SceneTrees& trees = now->shared_trees();
    if (trees.static_tree->instances_so_far() != nullptr ||
        trees.dynamic_tree->instances_so_far() != nullptr) {
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
