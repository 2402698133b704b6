// The last revisions of a scene.
#include "server/scenes/history.h"

#include <utility>

namespace sightline::server::scenes {
void RecentRevisions::reserve_more(std::size_t entries) {
  const std::lock_guard lock(mutex_);
  history_.reserve_more(entries);
}

RecentRevisions::SnapshotPointer RecentRevisions::retain(SnapshotPointer snapshot) {
  const std::lock_guard lock(mutex_);
  if (!history_.empty() && history_.newest().snapshot->revision() == snapshot->revision()) {
    history_.newest().snapshot.swap(snapshot);
    return snapshot;
  }
  history_.append({.snapshot = std::move(snapshot), .charge = {}});
  return nullptr;
}

std::vector<RecentRevisions::Kept> RecentRevisions::account(std::uint64_t bytes, Charge charge,
                                                            std::uint64_t trees) noexcept {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return {};  // drop_all() came in between
  history_.add_weight(bytes);
  history_.newest().charge = std::move(charge);
  history_.newest().trees = trees;
  return history_.trim();
}

RecentRevisions::SnapshotPointer RecentRevisions::find(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return nullptr;
  const std::uint64_t oldest = history_.oldest().snapshot->revision();
  if (revision < oldest || revision - oldest >= history_.size()) return nullptr;
  return history_[revision - oldest].snapshot;
}

RecentRevisions::SnapshotPointer RecentRevisions::oldest() const {
  const std::lock_guard lock(mutex_);
  return history_.empty() ? nullptr : history_.oldest().snapshot;
}

std::uint64_t RecentRevisions::oldest_or(std::uint64_t head) const {
  const std::lock_guard lock(mutex_);
  return history_.empty() ? head : history_.oldest().snapshot->revision();
}

std::vector<RecentRevisions::Kept> RecentRevisions::drop_all() noexcept {
  const std::lock_guard lock(mutex_);
  return history_.trim_to(0);
}

}  // namespace sightline::server::scenes
