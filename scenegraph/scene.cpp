// Applying a batch of updates: check and edit a private copy, then publish it whole.
#include "scenegraph/scene.h"

#include <new>
#include <unordered_map>
#include <utility>

#include "scenegraph/instances/prebuild.h"
#include "scenegraph/revision/draft.h"

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

Scene::Scene() : current_(std::make_shared<revision::Snapshot>(0, hierarchy::Hierarchy{})) {}

std::shared_ptr<const revision::Snapshot> Scene::snapshot() const {
  const std::lock_guard lock(current_mutex_);
  return current_;
}

Result<Applied> Scene::apply(const std::vector<model::Update>& updates,
                             const ApplyOptions& options) {
  std::shared_ptr<const revision::Snapshot> base;  // released outside the lock
  const std::lock_guard writer(writer_);
  base = snapshot();
  if (options.expected_revision && *options.expected_revision != base->revision()) {
    return Error{Code::kAborted,
                 "expected revision " + std::to_string(*options.expected_revision) +
                     ", but the scene is at " + std::to_string(base->revision()),
                 "REVISION_MISMATCH"};
  }
  revision::Draft draft(*base, next_id_, options.charge, options.cancelled);
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (const Status status = draft.apply(updates[i]); !status) {
      Error error = status.error();
      error.message = "update " + std::to_string(i) + ": " + error.message;
      return error;
    }
  }
  if (const Status status = draft.finish(); !status) return status.error();

  Applied applied{base->revision() + 1, draft.put_nodes()};
  const model::NodeId next_id = draft.next_id();
  std::vector<model::NodeId> changed = draft.changed();
  std::shared_ptr<const revision::Snapshot> next = std::move(draft).publish(applied.revision);
  applied.rebuild_static = settle_policy_.add(*next, std::move(changed));
  if (options.before_publish) options.before_publish(applied);
  next_id_ = next_id;
  publish(std::move(next));
  return applied;
}

void Scene::publish(std::shared_ptr<const revision::Snapshot> next) {
  // The old snapshot is released outside the lock: freeing it may take long.
  const std::lock_guard lock(current_mutex_);
  current_.swap(next);
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
  if (new_static == nullptr) return;
  const std::shared_ptr<const revision::Snapshot> now = snapshot();
  publish(with_new_static(*now, new_static, recently_changed, changed));
}

std::uint64_t Scene::drop_trees() {
  std::shared_ptr<const revision::Snapshot> now;  // released outside the lock
  {
    const std::lock_guard writer(writer_);
    now = snapshot();
    const instances::SceneTrees& trees = now->shared_trees();
    if (trees.static_tree->instances_so_far() != nullptr ||
        trees.dynamic_tree->instances_so_far() != nullptr)
      publish(std::make_shared<const revision::Snapshot>(now->revision(), now->hierarchy()));
  }
  std::uint64_t bytes = 0;
  for (const model::Mesh* mesh : now->meshes()) bytes += mesh->drop_tree();
  return bytes;
}

}  // namespace sightline::scenegraph
