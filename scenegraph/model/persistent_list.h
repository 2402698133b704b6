// An immutable-by-sharing list: copies share its chunks, and a change copies the chunks it meets.
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace sightline::scenegraph::model {

/// A list of which a copy costs one pointer for each kChunk entries. Threads: copies are
/// independent; one object is not for concurrent change.
template <class T>
class PersistentList {
  static constexpr std::size_t kChunk = 1024;
  /// A chunk is never empty. `least` and `greatest` tell which chunks need not be searched.
  struct Chunk {
    std::vector<T> entries;
    T least{}, greatest{};
  };
  using ChunkPointer = std::shared_ptr<const Chunk>;

 public:
  using value_type = T;

  class Iterator {
   public:
    using value_type = T;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    Iterator(const ChunkPointer* chunk, std::size_t index) : chunk_(chunk), index_(index) {}
    const T& operator*() const { return (*chunk_)->entries[index_]; }
    Iterator& operator++() {
      if (++index_ == (*chunk_)->entries.size()) {
        ++chunk_;
        index_ = 0;
      }
      return *this;
    }
    Iterator operator++(int) {
      Iterator before = *this;
      ++*this;
      return before;
    }
    bool operator==(const Iterator&) const = default;

   private:
    const ChunkPointer* chunk_ = nullptr;
    std::size_t index_ = 0;
  };

  PersistentList() = default;
  PersistentList(std::initializer_list<T> entries) { append(entries); }
  explicit PersistentList(std::span<const T> entries) { append(entries); }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& front() const { return *begin(); }
  Iterator begin() const { return {chunks_.data(), 0}; }
  Iterator end() const { return {chunks_.data() + chunks_.size(), 0}; }
  friend bool operator==(const PersistentList& a, const std::vector<T>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

  /// Copies of `count` entries from `first` on; fewer at the end of the list.
  std::vector<T> slice(std::size_t first, std::size_t count) const {
    std::vector<T> copies;
    for (const ChunkPointer& chunk : chunks_) {
      const std::span<const T> entries = chunk->entries;
      if (first < entries.size()) {
        const auto part =
            entries.subspan(first).first(std::min(entries.size() - first, count - copies.size()));
        copies.insert(copies.end(), part.begin(), part.end());
      }
      first -= std::min(first, entries.size());
      if (copies.size() == count) break;
    }
    return copies;
  }

  void append(std::span<const T> entries) {
    size_ += entries.size();
    if (!chunks_.empty() && chunks_.back()->entries.size() < kChunk && !entries.empty()) {
      std::vector<T> last = chunks_.back()->entries;
      const auto more = entries.first(std::min(kChunk - last.size(), entries.size()));
      last.insert(last.end(), more.begin(), more.end());
      chunks_.back() = chunk_of(std::move(last));
      entries = entries.subspan(more.size());
    }
    for (; !entries.empty(); entries = entries.subspan(std::min(kChunk, entries.size()))) {
      const auto part = entries.first(std::min(kChunk, entries.size()));
      chunks_.push_back(chunk_of({part.begin(), part.end()}));
    }
  }

  /// Removes, for each of the values, the first entry that equals it.
  void erase_first(std::span<const T> values) {
    Doomed doomed(values);
    std::vector<ChunkPointer> kept;
    for (ChunkPointer& chunk : chunks_) {
      if (doomed.may_be_in(*chunk)) {
        std::vector<T> entries;
        std::copy_if(chunk->entries.begin(), chunk->entries.end(), std::back_inserter(entries),
                     [&](const T& entry) { return !doomed.take(entry); });
        size_ -= chunk->entries.size() - entries.size();
        if (entries.empty()) continue;
        if (entries.size() < chunk->entries.size()) chunk = chunk_of(std::move(entries));
      }
      if (!kept.empty() && kept.back()->entries.size() + chunk->entries.size() <= kChunk / 2) {
        std::vector<T> joined = kept.back()->entries;
        joined.insert(joined.end(), chunk->entries.begin(), chunk->entries.end());
        kept.back() = chunk_of(std::move(joined));
      } else {
        kept.push_back(std::move(chunk));
      }
    }
    chunks_ = std::move(kept);
  }

 private:
  /// Values to be removed, and how many of each are left to be found.
  class Doomed {
   public:
    explicit Doomed(std::span<const T> values) : values_(values.begin(), values.end()) {
      std::sort(values_.begin(), values_.end());
      taken_.resize(values_.size());
    }
    bool may_be_in(const Chunk& chunk) const {
      const auto least = std::lower_bound(values_.begin(), values_.end(), chunk.least);
      return least != values_.end() && *least <= chunk.greatest;
    }
    /// `taken_`, at the first of equal values, counts those that were found.
    bool take(const T& entry) {
      const auto [first, last] = std::equal_range(values_.begin(), values_.end(), entry);
      if (first == last) return false;
      std::size_t& taken = taken_[static_cast<std::size_t>(first - values_.begin())];
      if (taken == static_cast<std::size_t>(last - first)) return false;
      ++taken;
      return true;
    }

   private:
    std::vector<T> values_;
    std::vector<std::size_t> taken_;
  };

  static ChunkPointer chunk_of(std::vector<T> entries) {
    const auto [least, greatest] = std::minmax_element(entries.begin(), entries.end());
    auto chunk = std::make_shared<Chunk>();
    chunk->least = *least;
    chunk->greatest = *greatest;
    chunk->entries = std::move(entries);
    return chunk;
  }

  std::vector<ChunkPointer> chunks_;
  std::size_t size_ = 0;
};

}  // namespace sightline::scenegraph::model
