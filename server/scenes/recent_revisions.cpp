// The last revisions of a scene.
#include "server/scenes/recent_revisions.h"

#include <utility>

namespace sightline::server::scenes {

RecentRevisions::SnapshotPointer RecentRevisions::retain(SnapshotPointer snapshot) {
  const std::lock_guard lock(mutex_);
  if (!kept_.empty() && kept_.back().snapshot->revision() == snapshot->revision()) {
    kept_.back().snapshot.swap(snapshot);
    return snapshot;
  }
  kept_.push_back({std::move(snapshot)});
  return nullptr;
}

std::vector<RecentRevisions::SnapshotPointer> RecentRevisions::account(std::uint64_t bytes) {
  std::vector<SnapshotPointer> dropped;
  const std::lock_guard lock(mutex_);
  if (kept_.empty()) return dropped;  // forgotten meanwhile
  kept_.back().bytes = bytes;
  bytes_ += bytes;
  while (!kept_.empty() && (kept_.size() > limits_.revisions || bytes_ > limits_.bytes)) {
    bytes_ -= kept_.front().bytes;
    dropped.push_back(std::move(kept_.front().snapshot));
    kept_.pop_front();
  }
  return dropped;
}

RecentRevisions::SnapshotPointer RecentRevisions::find(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  if (kept_.empty()) return nullptr;
  const std::uint64_t oldest = kept_.front().snapshot->revision();
  if (revision < oldest || revision - oldest >= kept_.size()) return nullptr;
  return kept_[revision - oldest].snapshot;
}

std::uint64_t RecentRevisions::oldest_or(std::uint64_t head) const {
  const std::lock_guard lock(mutex_);
  return kept_.empty() ? head : kept_.front().snapshot->revision();
}

std::vector<RecentRevisions::SnapshotPointer> RecentRevisions::drop_all() {
  std::vector<SnapshotPointer> dropped;
  const std::lock_guard lock(mutex_);
  for (Kept& kept : kept_) dropped.push_back(std::move(kept.snapshot));
  kept_.clear();
  bytes_ = 0;
  return dropped;
}

}  // namespace sightline::server::scenes
