// The cuts of the revisions that were asked for last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "scenegraph/query/shard_cut.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::server::shards {

/// Cuts that are kept, of all scenes.
inline constexpr std::size_t kCutsKept = 16;

/// Threads: any. Threads that want one cut at the same time wait for the first to make it.
class ShardCuts {
 public:
  using CutPointer = std::shared_ptr<const scenegraph::query::ShardCut>;

  /// The cut of a revision, which is made once. `shards`: the same in all calls. Throws
  /// std::bad_alloc.
  CutPointer find_or_make(const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot,
                          std::uint32_t shards);

 private:
  struct Entry {
    std::weak_ptr<const scenegraph::revision::Snapshot> snapshot{};
    std::mutex making{};
    CutPointer cut{};  // protected by `making`
  };
  std::shared_ptr<Entry> entry_of(
      const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot);

  std::mutex mutex_;
  std::list<std::shared_ptr<Entry>> entries_;  // last used first
};

}  // namespace sightline::server::shards
