// The last revisions of a scene.
#include "server/scenes/recent_revisions.h"

#include <utility>

namespace sightline::server::scenes {

RecentRevisions::SnapshotPointer RecentRevisions::retain(SnapshotPointer snapshot) {
  const std::lock_guard lock(mutex_);
  if (!history_.empty() && history_.newest()->revision() == snapshot->revision()) {
    history_.newest().swap(snapshot);
    return snapshot;
  }
  history_.append(std::move(snapshot));
  return nullptr;
}

std::vector<RecentRevisions::SnapshotPointer> RecentRevisions::account(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return {};  // drop_all() came in between
  history_.add_weight(bytes);
  return history_.trim();
}

RecentRevisions::SnapshotPointer RecentRevisions::find(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return nullptr;
  const std::uint64_t oldest = history_.oldest()->revision();
  if (revision < oldest || revision - oldest >= history_.size()) return nullptr;
  return history_[revision - oldest];
}

std::uint64_t RecentRevisions::oldest_or(std::uint64_t head) const {
  const std::lock_guard lock(mutex_);
  return history_.empty() ? head : history_.oldest()->revision();
}

std::vector<RecentRevisions::SnapshotPointer> RecentRevisions::drop_all() {
  const std::lock_guard lock(mutex_);
  return history_.clear();
}

}  // namespace sightline::server::scenes
