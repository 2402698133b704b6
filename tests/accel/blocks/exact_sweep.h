// The cost of a tree of blocks, and of the one that exact sweeps over floats would build.
#pragma once

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <vector>

#include "accel/blocks/block.h"
#include "accel/blocks/hierarchy.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::tests {

/// Relative to nothing: for ratios.
inline double block_tree_cost(const accel::blocks::Node* node) {
  const double area = accel::geometry::half_area(node->box);
  if (node->leaf()) return area * (1 + 0.05 * accel::blocks::Block(node->leaf_words).triangles);
  return area * 0.5 + block_tree_cost(node->left) + block_tree_cost(node->right);
}

/// Computes the cost of a tree by full sweeps along all axes at every node.
class ExactSweep {
 public:
  struct Item {
    accel::geometry::Aabb box;
    std::uint32_t id;
  };
  explicit ExactSweep(const accel::geometry::MeshView& mesh) : mesh_(mesh) {}

  double cost(std::span<Item> items) const {
    accel::geometry::Aabb box;
    for (const Item& item : items) box.grow(item.box);
    const double area = half_area(box), triangles = 0.05 * static_cast<double>(items.size());
    const double as_leaf = area * (1 + triangles);
    if (items.size() == 1) return as_leaf;
    const Found found = search(items);
    if (vertices(items) <= accel::blocks::kBlockVertices &&
        items.size() <= accel::blocks::kBlockTriangles &&
        as_leaf <= area * (0.5 + triangles * 0.5) + found.cost * 0.6)
      return as_leaf;
    sort(items, found.axis);
    return area * 0.5 + cost(items.first(found.left)) + cost(items.subspan(found.left));
  }

 private:
  struct Found {
    double cost = std::numeric_limits<double>::infinity();
    std::size_t axis = 0, left = 0;
  };

  static void sort(std::span<Item> items, std::size_t axis) {
    std::sort(items.begin(), items.end(), [axis](const Item& a, const Item& b) {
      const float x = a.box.lo[axis] + a.box.hi[axis], y = b.box.lo[axis] + b.box.hi[axis];
      return x != y ? x < y : a.id < b.id;
    });
  }

  static double side(const accel::geometry::Aabb& box, std::size_t count) {
    return half_area(box) * static_cast<double>((count + 3) / 4);
  }

  static Found search(std::span<Item> items) {
    Found found;
    const std::size_t n = items.size();
    std::vector<double> right(n);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sort(items, axis);
      accel::geometry::Aabb box;
      for (std::size_t i = n; i-- > 1;) {
        box.grow(items[i].box);
        right[i] = side(box, n - i);
      }
      box = {};
      for (std::size_t i = 1; i < n; ++i) {
        box.grow(items[i - 1].box);
        const double sum = side(box, i) + right[i];
        if (sum < found.cost) found = {sum, axis, i};
      }
    }
    return found;
  }

  std::size_t vertices(std::span<const Item> items) const {
    std::set<std::uint32_t> all;
    for (const Item& item : items) {
      for (const std::uint32_t v : mesh_.faces[item.id]) all.insert(v);
    }
    return all.size();
  }

  accel::geometry::MeshView mesh_;
};

}  // namespace sightline::tests
