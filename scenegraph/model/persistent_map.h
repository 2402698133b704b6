// An immutable-by-sharing map from small integers: a copy is one pointer, a change copies one path.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

namespace sightline::scenegraph::model {

/// Keys are best dense (ids counted up): a radix tree of kFan-way blocks. Absent keys hold T{}.
/// Threads: copies are independent; one object is not for concurrent change.
template <class T>
class PersistentMap {
  static constexpr unsigned kBits = 5;
  static constexpr std::size_t kFan = std::size_t{1} << kBits;
  static constexpr std::size_t kTogether = 32;
  using Block = std::shared_ptr<void>;
  // `stamp` says which edit made the block: no other changes it.
  struct Inner {
    std::uint64_t stamp = 0;
    std::array<Block, kFan> child;
  };
  struct Leaf {
    std::uint64_t stamp = 0;
    std::array<T, kFan> value{};
  };

 public:
  /// The value at key, or null.
  const T* find(std::uint64_t key) const {
    if (root_ == nullptr || (key >> kBits * (height_ + 1)) != 0) return nullptr;
    const void* block = root_.get();
    for (unsigned h = height_; h > 0; --h) {
      block = static_cast<const Inner*>(block)->child[digit(key, h)].get();
      if (block == nullptr) return nullptr;
    }
    const T& value = static_cast<const Leaf*>(block)->value[digit(key, 0)];
    return value == T{} ? nullptr : &value;
  }

  /// find() for each key, in order. In a map larger than the caches this is much faster than single
  /// calls: keys descend together, so that cache misses overlap.
  void find_all(std::span<const std::uint64_t> keys, std::span<const T*> values) const {
    for (std::size_t first = 0; first < keys.size(); first += kTogether) {
      const std::size_t count = std::min(kTogether, keys.size() - first);
      find_together(keys.subspan(first, count), values.subspan(first, count));
    }
  }

  /// Sets the value at key, or removes the key if the value is T{}.
  void set(std::uint64_t key, T value) { Edit(*this).set(key, std::move(value)); }

  /// Many changes, which copy each block once. The map may be read meanwhile but not copied.
  class Edit {
   public:
    explicit Edit(PersistentMap& map) : map_(map) {}
    Edit(const Edit&) = delete;
    Edit& operator=(const Edit&) = delete;

    void set(std::uint64_t key, T value) {
      const bool before = map_.find(key) != nullptr;
      const bool after = !(value == T{});
      if (!before && !after) return;
      while ((key >> kBits * (map_.height_ + 1)) != 0) map_.raise(stamp_);
      change(map_.root_, map_.height_, key, std::move(value), !after);
      if (map_.root_ == nullptr) map_.height_ = 0;
      map_.size_ += (after ? 1u : 0u);
      map_.size_ -= (before ? 1u : 0u);
    }

   private:
    /// The block for changing: itself if this edit has made it, else a copy in its place.
    template <class Kind>
    Kind& own(Block& block) const {
      auto* kind = static_cast<Kind*>(block.get());
      if (kind == nullptr || kind->stamp != stamp_) {
        auto copy = kind == nullptr ? std::make_shared<Kind>() : std::make_shared<Kind>(*kind);
        kind = copy.get();
        kind->stamp = stamp_;
        block = std::move(copy);
      }
      return *kind;
    }

    /// Changes a value. A block that holds nothing any more is dropped: else a map whose keys are
    /// counted up, and removed, would grow for ever.
    void change(Block& block, unsigned height, std::uint64_t key, T&& value, bool removes) const {
      if (height == 0) {
        auto& values = own<Leaf>(block).value;
        values[digit(key, 0)] = std::move(value);
        if (removes && std::ranges::all_of(values, [](const T& v) { return v == T{}; }))
          block.reset();
      } else {
        auto& children = own<Inner>(block).child;
        Block& child = children[digit(key, height)];
        change(child, height - 1, key, std::move(value), removes);
        if (child == nullptr &&
            std::ranges::all_of(children, [](const Block& b) { return b == nullptr; }))
          block.reset();
      }
    }

    PersistentMap& map_;
    const std::uint64_t stamp_ = next_stamp();
  };

  std::size_t size() const { return size_; }

  /// Refers to the map as long as one of its copies lives. Threads: any.
  class Weak {
   public:
    explicit Weak(const PersistentMap& map)
        : root_(map.root_), height_(map.height_), size_(map.size_) {}

    /// Whether no copy lives, or the map is empty.
    bool expired() const { return root_.expired(); }
    /// A copy of the map; empty if no copy lives.
    PersistentMap lock() const {
      PersistentMap map;
      map.root_ = root_.lock();
      if (map.root_ == nullptr) return map;
      map.height_ = height_;
      map.size_ = size_;
      return map;
    }
    /// A pointer that lives as long as a copy of the map.
    std::weak_ptr<const void> life() const { return root_; }

   private:
    std::weak_ptr<void> root_;
    unsigned height_ = 0;
    std::size_t size_ = 0;
  };

  /// How many keys have another value here than in `other`, or none there. Cost: proportional to
  /// the blocks that the maps do not share.
  std::size_t count_not_in(const PersistentMap& other) const {
    const void* there = other.root_.get();
    unsigned height = other.height_;
    for (; there != nullptr && height > height_; --height)
      there = static_cast<const Inner*>(there)->child[0].get();
    return root_ == nullptr ? 0 : count_block(root_.get(), height_, there, height);
  }

  /// Calls visit(key, value) for every key, in ascending order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    if (root_ != nullptr) visit_block(root_.get(), height_, 0, visit);
  }

 private:
  static std::uint64_t next_stamp() {
    static std::atomic<std::uint64_t> last{0};
    return last.fetch_add(1, std::memory_order_relaxed) + 1;
  }

  static std::size_t digit(std::uint64_t key, unsigned height) {
    return (key >> kBits * height) & (kFan - 1);
  }

  void find_together(std::span<const std::uint64_t> keys, std::span<const T*> values) const {
    std::array<const void*, kTogether> at;
    for (std::size_t k = 0; k < keys.size(); ++k)
      at[k] = root_ == nullptr || (keys[k] >> kBits * (height_ + 1)) != 0 ? nullptr : root_.get();
    for (unsigned h = height_; h > 0; --h) {
      for (std::size_t k = 0; k < keys.size(); ++k) {
        if (at[k] != nullptr)
          at[k] = static_cast<const Inner*>(at[k])->child[digit(keys[k], h)].get();
      }
    }
    for (std::size_t k = 0; k < keys.size(); ++k) {
      values[k] =
          at[k] == nullptr ? nullptr : &static_cast<const Leaf*>(at[k])->value[digit(keys[k], 0)];
      if (values[k] != nullptr && *values[k] == T{}) values[k] = nullptr;
    }
  }

  /// Adds a level above the root.
  void raise(std::uint64_t stamp) {
    if (root_ != nullptr) {
      auto inner = std::make_shared<Inner>();
      inner->stamp = stamp;
      inner->child[0] = std::move(root_);
      root_ = std::move(inner);
    }
    ++height_;
  }

  /// Counts values in a block that are not `there`, which may be lower, or null.
  static std::size_t count_block(const void* here, unsigned height, const void* there,
                                 unsigned there_height) {
    if (here == there) return 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kFan; ++i) {
      if (height == 0) {
        const T& value = static_cast<const Leaf*>(here)->value[i];
        const bool is_there =
            there != nullptr && value == static_cast<const Leaf*>(there)->value[i];
        count += value == T{} || is_there ? 0u : 1u;
        continue;
      }
      const Block& child = static_cast<const Inner*>(here)->child[i];
      if (child == nullptr) continue;
      const void* other = nullptr;
      if (there != nullptr && there_height == height) {
        other = static_cast<const Inner*>(there)->child[i].get();
      } else if (i == 0) {
        other = there;
      }
      count += count_block(child.get(), height - 1, other, std::min(there_height, height - 1));
    }
    return count;
  }

  template <class Visit>
  static void visit_block(const void* block, unsigned height, std::uint64_t prefix, Visit& visit) {
    for (std::size_t i = 0; i < kFan; ++i) {
      const std::uint64_t key = prefix << kBits | i;
      if (height == 0) {
        const T& value = static_cast<const Leaf*>(block)->value[i];
        if (!(value == T{})) visit(key, value);
      } else if (const Block& child = static_cast<const Inner*>(block)->child[i]) {
        visit_block(child.get(), height - 1, key, visit);
      }
    }
  }

  Block root_;
  unsigned height_ = 0;
  std::size_t size_ = 0;
};

}  // namespace sightline::scenegraph::model
