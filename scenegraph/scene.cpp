// Applying a batch of updates: check and edit a private copy, then publish it whole.
#include "scenegraph/scene.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "scenegraph/draft.h"

namespace sightline::scenegraph {

Scene::Scene() : current_(std::make_shared<Snapshot>(0, Hierarchy{})) {}

std::shared_ptr<const Snapshot> Scene::snapshot() const {
  const std::lock_guard lock(current_mutex_);
  return current_;
}

Result<Applied> Scene::apply(const std::vector<Update>& updates,
                             std::optional<std::uint64_t> expected_revision) {
  const std::lock_guard writer(writer_);
  const std::shared_ptr<const Snapshot> base = snapshot();
  if (expected_revision && *expected_revision != base->revision()) {
    return Error{Code::kAborted,
                 "expected revision " + std::to_string(*expected_revision) +
                     ", but the scene is at " + std::to_string(base->revision()),
                 "REVISION_MISMATCH"};
  }
  Draft draft(*base, next_id_);
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
  std::shared_ptr<const Snapshot> next = std::move(draft).publish(applied.revision);
  const std::lock_guard lock(current_mutex_);
  current_ = std::move(next);
  return applied;
}

}  // namespace sightline::scenegraph
