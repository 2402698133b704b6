// What a scene keeps of its past: logs of bounded size, and recent revisions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "server/exec/memory_account.h"

namespace sightline::server::scenes {

struct HistoryLimits {
  std::size_t entries = 0;
  std::uint64_t weight = 0;     ///< Sum of all entries.
  std::size_t min_entries = 0;  ///< The newest ones, kept whatever their weight.
};

/// A log of the last entries, oldest first, bounded in number and in total weight. A dropped entry
/// is returned, so that its owner can destroy it outside a lock. Threads: one at a time.
template <class Entry>
class History {
 public:
  explicit History(HistoryLimits limits) : limits_(limits) {}
  /// The places of entries are charged to `memory`.
  History(HistoryLimits limits, exec::MemoryAccount& memory)
      : limits_(limits), slots_(memory.record(exec::Held::kLogs, 0)) {}

  /// Reserves memory for `entries` more. Throws std::bad_alloc.
  void reserve_more(std::size_t entries = 1) {
    if (items_.capacity() - items_.size() >= entries) return;
    items_.reserve(2 * items_.size() + entries);
    slots_.resize(items_.capacity() * sizeof(Item));
  }

  /// Adds an entry; drops nothing. Does not throw after reserve_more().
  void append(Entry entry, std::uint64_t weight = 0) {
    items_.push_back({std::move(entry), weight});
    weight_ += weight;
  }

  /// Adds to the weight of the newest entry.
  void add_weight(std::uint64_t weight) {
    items_.back().weight += weight;
    weight_ += weight;
  }

  /// Drops the oldest entries until the limits hold. Without memory for what it returns, it
  /// destroys them itself.
  std::vector<Entry> trim() noexcept {
    std::size_t count = 0;
    for (std::size_t left = items_.size();
         left > limits_.min_entries && (left > limits_.entries || weight_ > limits_.weight); --left)
      weight_ -= items_[count++].weight;
    return drop(count);
  }

  /// Drops the oldest entries until at most `entries` are left, as trim().
  std::vector<Entry> trim_to(std::size_t entries) noexcept {
    std::size_t count = 0;
    while (items_.size() - count > entries) weight_ -= items_[count++].weight;
    return drop(count);
  }

  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  /// Index 0 is the oldest entry.
  const Entry& operator[](std::size_t index) const { return items_[index].entry; }
  const Entry& oldest() const { return items_.front().entry; }
  const Entry& newest() const { return items_.back().entry; }
  Entry& newest() { return items_.back().entry; }

 private:
  struct Item {
    Entry entry;
    std::uint64_t weight = 0;
  };

  std::vector<Entry> drop(std::size_t count) noexcept {
    std::vector<Entry> dropped;
    try {
      dropped.reserve(count);
      for (std::size_t i = 0; i < count; ++i) dropped.push_back(std::move(items_[i].entry));
    } catch (const std::bad_alloc&) {
    }
    items_.erase(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(count));
    return dropped;
  }

  HistoryLimits limits_;
  exec::MemoryAccount::Charge slots_;
  std::vector<Item> items_;
  std::uint64_t weight_ = 0;
};

struct RecentLimits {
  std::size_t revisions = 64;
  /// Bytes that the kept revisions do not share with later ones.
  std::uint64_t bytes = std::uint64_t{64} << 20;
};

/// The last revisions, for reads of an exact one. Threads: one that calls retain() and account(),
/// any for the other members.
class RecentRevisions {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;
  using Charge = exec::MemoryAccount::Charge;
  struct Kept {
    SnapshotPointer snapshot;
    Charge charge;
    std::uint64_t trees = 0;  ///< Bytes of the scene's trees in the charge.
  };

  explicit RecentRevisions(RecentLimits limits = {})
      : history_({.entries = limits.revisions, .weight = limits.bytes}) {}

  /// Reserves memory for `entries` more. Throws std::bad_alloc.
  void reserve_more(std::size_t entries);

  /// Adds the next revision, or replaces the snapshot of the newest one. Call it before the
  /// following revision is published: a reader that knows that revision then finds this one.
  /// Returns the replaced snapshot, or null.
  /// Does not throw after reserve_more().
  [[nodiscard]] SnapshotPointer retain(SnapshotPointer snapshot);

  /// Call it after the following revision is published. `bytes`: what that revision does not share
  /// with the newest kept one; `charge`: for them, and `trees` of them of the scene's trees.
  /// Returns what is no longer kept; destroying it may take long.
  [[nodiscard]] std::vector<Kept> account(std::uint64_t bytes, Charge charge = {},
                                          std::uint64_t trees = 0) noexcept;

  /// Null if the revision is not kept.
  SnapshotPointer find(std::uint64_t revision) const;
  /// The oldest one; null if none is kept.
  SnapshotPointer oldest() const;
  /// The oldest revision that is kept; `head` if none is.
  std::uint64_t oldest_or(std::uint64_t head) const;

  /// Drops all revisions and returns them.
  [[nodiscard]] std::vector<Kept> drop_all() noexcept;

 private:
  mutable std::mutex mutex_;  // held for a few pointer copies
  History<Kept> history_;     // consecutive revisions
};

}  // namespace sightline::server::scenes
