// The last revisions of a scene, for reads of an exact one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::server::scenes {

struct RecentLimits {
  std::size_t revisions = 64;
  /// What the later revisions no longer share with those that are kept.
  std::uint64_t bytes = std::uint64_t{64} << 20;
};

/// Threads: one that keeps and charges, any that find.
class RecentRevisions {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;

  explicit RecentRevisions(RecentLimits limits = {}) : limits_(limits) {}

  /// Keeps a revision: that after the last, or the last one anew. To be called before the next is
  /// published, so that a reader who knows of that finds this. Returns what it takes the place of.
  [[nodiscard]] SnapshotPointer retain(SnapshotPointer snapshot);

  /// The revision after the last is published and has replaced so many bytes of it. Returns what is
  /// no longer kept: to be freed where nobody waits for it.
  [[nodiscard]] std::vector<SnapshotPointer> account(std::uint64_t bytes);

  /// Null if it is not kept.
  SnapshotPointer find(std::uint64_t revision) const;
  /// The oldest that is kept; `head` if none is.
  std::uint64_t oldest_or(std::uint64_t head) const;

  /// Forgets all; they are returned as by account(). Threads: any.
  [[nodiscard]] std::vector<SnapshotPointer> drop_all();

 private:
  struct Kept {
    SnapshotPointer snapshot;
    std::uint64_t bytes = 0;  // that the next revision does not share
  };

  const RecentLimits limits_;
  mutable std::mutex mutex_;  // held for a few pointers
  std::deque<Kept> kept_;     // without gaps
  std::uint64_t bytes_ = 0;
};

}  // namespace sightline::server::scenes
