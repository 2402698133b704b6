// The last revisions of a scene, for reads of an exact one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "server/scenes/history.h"

namespace sightline::server::scenes {

struct RecentLimits {
  std::size_t revisions = 64;
  /// Bytes that the kept revisions do not share with later ones.
  std::uint64_t bytes = std::uint64_t{64} << 20;
};

/// Threads: one that calls retain() and account(), any for the other members.
class RecentRevisions {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;

  explicit RecentRevisions(RecentLimits limits = {})
      : history_({.entries = limits.revisions, .weight = limits.bytes}) {}

  /// Adds the next revision, or replaces the snapshot of the newest one. Call it before the
  /// following revision is published: a reader that knows that revision then finds this one.
  /// Returns the replaced snapshot, or null.
  [[nodiscard]] SnapshotPointer retain(SnapshotPointer snapshot);

  /// Call it after the following revision is published. `bytes`: what that revision does not share
  /// with the newest kept one. Returns the snapshots that are no longer kept; destroying them may
  /// take long.
  [[nodiscard]] std::vector<SnapshotPointer> account(std::uint64_t bytes);

  /// Null if the revision is not kept.
  SnapshotPointer find(std::uint64_t revision) const;
  /// The oldest revision that is kept; `head` if none is.
  std::uint64_t oldest_or(std::uint64_t head) const;

  /// Drops all revisions and returns them.
  [[nodiscard]] std::vector<SnapshotPointer> drop_all();

 private:
  mutable std::mutex mutex_;          // held for a few pointer copies
  History<SnapshotPointer> history_;  // consecutive revisions
};

}  // namespace sightline::server::scenes
