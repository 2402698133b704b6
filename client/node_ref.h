// How updates name nodes: by ids, as hits and answers have them, or by aliases.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <ranges>
#include <type_traits>
#include <vector>

namespace sightline::client {

/// What can name a node: an integer of any type, but no bool.
template <class T>
concept NodeNumber = std::integral<T> && !std::same_as<std::remove_cv_t<T>, bool>;

/// A node's id (> 0), the negative alias that an earlier PutNode of the same batch gave to the
/// node, or 0: none. Ids are taken as they are in hits, in Applied and in NodeInfo. An id above
/// 2^63 - 1, which no node has, becomes 2^63 - 1, and the server refuses it.
class NodeRef {
 public:
  constexpr NodeRef() = default;
  template <NodeNumber T>
  constexpr NodeRef(T number) : number_(clamped(number)) {}
  /// Only integers name nodes.
  template <class T>
    requires(std::floating_point<T> || std::same_as<T, bool>)
  NodeRef(T) = delete;

  constexpr operator std::int64_t() const { return number_; }

  constexpr NodeRef& operator++() { return ++number_, *this; }
  constexpr NodeRef& operator--() { return --number_, *this; }
  constexpr NodeRef operator++(int) { return number_++; }
  constexpr NodeRef operator--(int) { return number_--; }

 private:
  template <class T>
  static constexpr std::int64_t clamped(T number) {
    if constexpr (std::is_unsigned_v<T> && sizeof(T) >= sizeof(std::int64_t)) {
      return static_cast<std::int64_t>(
          std::min<T>(number, std::numeric_limits<std::int64_t>::max()));
    } else {
      return static_cast<std::int64_t>(number);
    }
  }

  std::int64_t number_ = 0;
};

/// A vector of nodes that any range of ids or aliases can make: the nodes of hits, for example.
class NodeRefs : public std::vector<NodeRef> {
 public:
  using std::vector<NodeRef>::vector;
  template <class Range>
    requires(!std::same_as<Range, NodeRefs> && std::ranges::input_range<const Range> &&
             (NodeNumber<std::ranges::range_value_t<const Range>> ||
              std::same_as<std::ranges::range_value_t<const Range>, NodeRef>))
  NodeRefs(const Range& numbers)
      : std::vector<NodeRef>(std::ranges::begin(numbers), std::ranges::end(numbers)) {}
};

}  // namespace sightline::client

template <>
struct std::hash<sightline::client::NodeRef> : std::hash<std::int64_t> {};
template <>
struct std::numeric_limits<sightline::client::NodeRef> : std::numeric_limits<std::int64_t> {};
