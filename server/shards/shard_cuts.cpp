// Finds or makes the cuts of revisions.
#include "server/shards/shard_cuts.h"

#include <algorithm>

namespace sightline::server::shards {

using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;

std::shared_ptr<ShardCuts::Entry> ShardCuts::entry_of(const SnapshotPointer& snapshot) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry->snapshot.expired(); });
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const auto& entry) {
    // lock() is not used: it may release the last reference to a revision here.
    return !entry->snapshot.owner_before(snapshot) && !snapshot.owner_before(entry->snapshot);
  });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front();
  }
  auto made = std::make_shared<Entry>();
  made->snapshot = snapshot;
  entries_.push_front(made);
  if (entries_.size() > kCutsKept) entries_.pop_back();
  return made;
}

ShardCuts::CutPointer ShardCuts::find_or_make(const SnapshotPointer& snapshot,
                                              std::uint32_t shards) {
  const std::shared_ptr<Entry> entry = entry_of(snapshot);
  const std::lock_guard lock(entry->making);
  if (entry->cut == nullptr)
    entry->cut = std::make_shared<const scenegraph::query::ShardCut>(*snapshot, shards);
  return entry->cut;
}

}  // namespace sightline::server::shards
