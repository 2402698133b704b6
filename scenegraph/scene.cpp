// Applying a batch of updates: check and edit a private copy, then publish it whole.
#include "scenegraph/scene.h"

#include <new>
#include <unordered_map>
#include <utility>

#include "scenegraph/instances/prebuild.h"
#include "scenegraph/revision/draft.h"

namespace sightline::scenegraph {

namespace {

/// Less what is restless, and grown where rays have been. Null where they have not been, or where
/// there is no memory for it.
std::shared_ptr<const instances::SceneHalf> settled_half(
    const revision::Snapshot& base, const std::vector<model::NodeId>& restless) {
  const instances::Instances* still = base.halves().still->instances_so_far();
  if (still == nullptr) return nullptr;
  try {
    hierarchy::Hierarchy hierarchy = base.hierarchy();
    hierarchy.movers = revision::topmost_of(hierarchy, restless);
    auto settled = std::make_shared<const instances::SceneHalf>(instances::Half::kStatic,
                                                                std::move(hierarchy));
    grow_alike(*still, settled->instances());
    return settled;
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
                             std::optional<std::uint64_t> expected_revision) {
  std::shared_ptr<const revision::Snapshot> base;  // given up outside the lock
  const std::lock_guard writer(writer_);
  base = snapshot();
  if (expected_revision && *expected_revision != base->revision()) {
    return Error{Code::kAborted,
                 "expected revision " + std::to_string(*expected_revision) +
                     ", but the scene is at " + std::to_string(base->revision()),
                 "REVISION_MISMATCH"};
  }
  revision::Draft draft(*base, next_id_);
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (Status status = draft.apply(updates[i]); !status) {
      Error error = status.error();
      error.message = "update " + std::to_string(i) + ": " + error.message;
      return error;
    }
  }
  if (Status status = draft.finish(); !status) return status.error();

  Applied applied{base->revision() + 1, draft.put_nodes()};
  next_id_ = draft.next_id();
  std::vector<model::NodeId> changed = draft.changed();
  std::shared_ptr<const revision::Snapshot> next = std::move(draft).publish(applied.revision);
  applied.settle = rest_.add(*next, std::move(changed));
  publish(std::move(next));
  return applied;
}

void Scene::publish(std::shared_ptr<const revision::Snapshot> next) {
  // The one before is given up outside the lock: it may be the last to hold much.
  const std::lock_guard lock(current_mutex_);
  current_.swap(next);
}

void Scene::settle() {
  const std::unique_lock settling(settling_, std::try_to_lock);
  if (!settling.owns_lock()) return;
  std::shared_ptr<const revision::Snapshot> base;
  std::vector<model::NodeId> restless;
  {
    const std::lock_guard writer(writer_);
    base = snapshot();
    restless = rest_.begin(base->revision());
  }
  const std::shared_ptr<const instances::SceneHalf> settled = settled_half(*base, restless);
  const std::lock_guard writer(writer_);
  const std::vector<model::NodeId> changed = rest_.end(base->revision());
  if (settled == nullptr) return;
  const std::shared_ptr<const revision::Snapshot> now = snapshot();
  publish(resettled(*now, settled, restless, changed));
}

}  // namespace sightline::scenegraph
