// The hits of one ray, each kept once although several cells may report it; at most a limit of the
// least.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sightline::accel::wide {

/// Collects values and keeps the `limit` least distinct ones. Uses memory for at most twice the
/// kept values, and reuses it after clear(). Amortised cost of add: logarithmic in the number kept.
template <class T>
class UniqueHits {
 public:
  explicit UniqueHits(std::size_t limit = std::numeric_limits<std::size_t>::max())
      : limit_(limit) {}

  void clear() {
    values_.clear();
    compact_at_ = kLeast;
  }

  /// Returns whether values were dropped: greatest() may be less than before.
  bool add(const T& value) {
    if (!values_.empty() && values_.back() == value)
      return false;  // by far the most frequent duplicate
    values_.push_back(value);
    if (values_.size() < compact_at_) return false;
    compact();
    return true;
  }

  /// The greatest kept value, after an add that returned true: greater values will not be kept.
  /// Null while fewer than `limit` are kept.
  const T* greatest() const { return values_.size() == limit_ ? &values_.back() : nullptr; }

  /// The kept values, ascending. Valid until the next add.
  std::span<const T> sorted() {
    compact();
    return values_;
  }

 private:
  static constexpr std::size_t kLeast = 32;

  void compact() {
    std::sort(values_.begin(), values_.end());
    values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
    if (values_.size() > limit_) values_.resize(limit_);
    compact_at_ = std::max(kLeast, 2 * values_.size());
  }

  std::size_t limit_;
  std::size_t compact_at_ = kLeast;
  std::vector<T> values_;
};

/// A hit in a list. Less is nearer; ties are ordered by node and primitive.
struct ListedHit {
  double t = 0;
  std::uint64_t node = 0;
  std::uint32_t primitive = 0;
  std::uint32_t instance = 0;  ///< The caller's number for the node.

  auto operator<=>(const ListedHit&) const = default;
};

}  // namespace sightline::accel::wide
