// A tree over points of a plane, which is asked for those in a triangle. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/importer/orientation.h"

namespace sightline::client::importer {

/// Keeps the numbers of points, which can be removed. `points` must stay as they are.
class PointTree {
 public:
  /// A tree of these numbers.
  void build(std::span<const PlanePoint> points, std::vector<std::uint32_t> numbers);

  /// Does nothing if the number is not in the tree.
  void remove(std::uint32_t number);

  /// Whether `is_met` is true for some number, of those whose points are not surely outside of the
  /// triangle a, b, c, which turns to the left. Points on its boundary are not outside.
  template <class IsMet>
  bool any(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c,
           const IsMet& is_met) const {
    std::size_t open[2 * kMostLevels] = {0};
    std::size_t count = nodes_.empty() ? 0 : 1;
    while (count > 0) {
      const std::size_t index = open[--count];
      const Node& node = nodes_[index];
      if (node.left == 0 || is_outside(node, a, b, c)) continue;
      if (2 * index + 2 < nodes_.size()) {
        open[count++] = 2 * index + 1;
        open[count++] = 2 * index + 2;
        continue;
      }
      for (std::size_t i = node.begin; i < node.end; ++i) {
        if (is_in_[numbers_[i]] && is_met(numbers_[i])) return true;
      }
    }
    return false;
  }

 private:
  static constexpr std::size_t kMostLevels = 33;
  static constexpr std::size_t kLeaf = 16;  // as many points, or fewer

  struct Node {
    PlanePoint lo, hi;
    std::size_t begin = 0, end = 0;  // range of numbers_
    std::size_t left = 0;            // numbers that were not removed
  };

  void split(std::size_t index, std::span<const PlanePoint> points);
  static bool is_outside(const Node& node, const PlanePoint& a, const PlanePoint& b,
                         const PlanePoint& c);

  std::vector<Node> nodes_;  // the children of node i are 2 i + 1 and 2 i + 2
  std::vector<std::uint32_t> numbers_;
  std::vector<std::size_t> leaf_of_;  // by number
  std::vector<bool> is_in_;           // by number
};

}  // namespace sightline::client::importer
