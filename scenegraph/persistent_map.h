// An immutable-by-sharing map from small integers: a copy is one pointer, a change copies one path.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace sightline::scenegraph {

/// Keys are best dense (ids counted up): a radix tree of kFan-way blocks. Absent keys hold T{}.
/// Threads: copies are independent; one object is not for concurrent change.
template <class T>
class PersistentMap {
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

  /// Sets or, with T{}, removes.
  void set(std::uint64_t key, T value) {
    const bool before = find(key) != nullptr;
    const bool after = !(value == T{});
    while (root_ == nullptr || (key >> kBits * (height_ + 1)) != 0) raise();
    root_ = with(root_, height_, key, std::move(value));
    size_ += (after ? 1u : 0u);
    size_ -= (before ? 1u : 0u);
  }

  std::size_t size() const { return size_; }

  /// Calls visit(key, value) for every key, in ascending order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    if (root_ != nullptr) visit_block(root_.get(), height_, 0, visit);
  }

 private:
  static constexpr unsigned kBits = 5;
  static constexpr std::size_t kFan = std::size_t{1} << kBits;
  using Block = std::shared_ptr<const void>;
  struct Inner {
    std::array<Block, kFan> child;
  };
  struct Leaf {
    std::array<T, kFan> value{};
  };

  static std::size_t digit(std::uint64_t key, unsigned height) {
    return (key >> kBits * height) & (kFan - 1);
  }

  /// One level more above the root.
  void raise() {
    if (root_ == nullptr) {
      root_ = std::make_shared<const Leaf>();
      height_ = 0;
      return;
    }
    auto inner = std::make_shared<Inner>();
    inner->child[0] = std::move(root_);
    root_ = std::move(inner);
    ++height_;
  }

  static Block with(const Block& block, unsigned height, std::uint64_t key, T value) {
    if (height == 0) {
      auto copy = block ? std::make_shared<Leaf>(*static_cast<const Leaf*>(block.get()))
                        : std::make_shared<Leaf>();
      copy->value[digit(key, 0)] = std::move(value);
      return copy;
    }
    auto copy = block ? std::make_shared<Inner>(*static_cast<const Inner*>(block.get()))
                      : std::make_shared<Inner>();
    Block& child = copy->child[digit(key, height)];
    child = with(child, height - 1, key, std::move(value));
    return copy;
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

}  // namespace sightline::scenegraph
