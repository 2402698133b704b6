// Splits at medians, until few points are left.
#include "client/importer/point_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sightline::client::importer {
namespace {

// Whether the whole box is surely to the right of the line from a to b.
bool is_right_of(const PlanePoint& lo, const PlanePoint& hi, const PlanePoint& a,
                 const PlanePoint& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double left = dx * ((dx > 0 ? hi.y : lo.y) - a.y);
  const double right = dy * ((dy > 0 ? lo.x : hi.x) - a.x);
  return left - right < -4e-16 * (std::abs(left) + std::abs(right));
}

}  // namespace

void PointTree::build(std::span<const PlanePoint> points, std::vector<std::uint32_t> numbers) {
  numbers_ = std::move(numbers);
  is_in_.assign(points.size(), false);
  leaf_of_.resize(points.size());
  for (const std::uint32_t number : numbers_) is_in_[number] = true;
  std::size_t leaves = 1;
  while (leaves * kLeaf < numbers_.size()) leaves *= 2;
  nodes_.assign(2 * leaves - 1, Node{});
  nodes_[0].end = numbers_.size();
  for (std::size_t i = 0; i < nodes_.size(); ++i) split(i, points);
}

void PointTree::split(std::size_t index, std::span<const PlanePoint> points) {
  Node& node = nodes_[index];
  node.left = node.end - node.begin;
  if (node.left == 0) return;
  node.lo = node.hi = points[numbers_[node.begin]];
  for (std::size_t i = node.begin; i < node.end; ++i) {
    const PlanePoint& p = points[numbers_[i]];
    node.lo = {std::min(node.lo.x, p.x), std::min(node.lo.y, p.y)};
    node.hi = {std::max(node.hi.x, p.x), std::max(node.hi.y, p.y)};
  }
  if (2 * index + 2 >= nodes_.size()) {
    for (std::size_t i = node.begin; i < node.end; ++i) leaf_of_[numbers_[i]] = index;
    return;
  }
  const std::size_t middle = node.begin + node.left / 2;
  const bool by_x = node.hi.x - node.lo.x > node.hi.y - node.lo.y;
  const auto at = [&](std::size_t i) { return numbers_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(node.begin), at(middle), at(node.end), [&](std::uint32_t a, std::uint32_t b) {
    return by_x ? points[a].x < points[b].x : points[a].y < points[b].y;
  });
  nodes_[2 * index + 1].begin = node.begin;
  nodes_[2 * index + 1].end = nodes_[2 * index + 2].begin = middle;
  nodes_[2 * index + 2].end = node.end;
}

void PointTree::remove(std::uint32_t number) {
  if (!is_in_[number]) return;
  is_in_[number] = false;
  for (std::size_t i = leaf_of_[number];; i = (i - 1) / 2) {
    --nodes_[i].left;
    if (i == 0) return;
  }
}

bool PointTree::is_outside(const Node& node, const PlanePoint& a, const PlanePoint& b,
                           const PlanePoint& c) {
  return std::max({a.x, b.x, c.x}) < node.lo.x || std::min({a.x, b.x, c.x}) > node.hi.x ||
         std::max({a.y, b.y, c.y}) < node.lo.y || std::min({a.y, b.y, c.y}) > node.hi.y ||
         is_right_of(node.lo, node.hi, a, b) || is_right_of(node.lo, node.hi, b, c) ||
         is_right_of(node.lo, node.hi, c, a);
}

}  // namespace sightline::client::importer
