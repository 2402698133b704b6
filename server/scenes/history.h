// A log of the last entries, bounded in their number and in their total weight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace sightline::server::scenes {

struct HistoryLimits {
  std::size_t entries = 0;
  std::uint64_t weight = 0;     ///< Sum over all entries.
  std::size_t min_entries = 0;  ///< The newest ones, kept whatever their weight.
};

/// Oldest first. A dropped entry is returned, so that its owner can destroy it outside a lock.
/// Threads: one at a time.
template <class Entry>
class History {
 public:
  explicit History(HistoryLimits limits) : limits_(limits) {}

  /// Adds an entry; drops nothing.
  void append(Entry entry, std::uint64_t weight = 0) {
    items_.push_back({std::move(entry), weight});
    weight_ += weight;
  }

  /// Adds to the weight of the newest entry.
  void add_weight(std::uint64_t weight) {
    items_.back().weight += weight;
    weight_ += weight;
  }

  /// Drops the oldest entries until the limits hold.
  std::vector<Entry> trim() {
    std::vector<Entry> dropped;
    while (items_.size() > limits_.min_entries &&
           (items_.size() > limits_.entries || weight_ > limits_.weight)) {
      weight_ -= items_.front().weight;
      dropped.push_back(std::move(items_.front().entry));
      items_.pop_front();
    }
    return dropped;
  }

  /// Drops all entries.
  std::vector<Entry> clear() {
    std::vector<Entry> dropped;
    for (Item& item : items_) dropped.push_back(std::move(item.entry));
    items_.clear();
    weight_ = 0;
    return dropped;
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

  HistoryLimits limits_;
  std::deque<Item> items_;
  std::uint64_t weight_ = 0;
};

}  // namespace sightline::server::scenes
