// Growing a few cuts over a sample, and sifting by them while a slice is in the cache.
#include "accel/lazy/split_tree.h"

#include <algorithm>

#include "accel/kdtree/sift.h"

namespace sightline::accel::lazy {
namespace {

/// A sample is a share of the list, but no more than that is of use.
constexpr std::size_t kStretch = 16;
constexpr std::size_t kMostSample = 4096;

/// From fewer a cut's cost is not known well enough.
constexpr std::size_t kLeastSample = 256;

}  // namespace

std::vector<std::size_t> sample_indices(std::size_t size) {
  const std::size_t stretch = std::max(kStretch, size / kMostSample);
  std::vector<std::size_t> indices(size / stretch);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const std::size_t mixed = (k + 1) * std::size_t{0x9e3779b97f4a7c15u} >> 32;
    indices[k] = k * stretch + mixed % stretch;
  }
  return indices;
}

struct SplitTree::Growth {
  const split::SplitSearch& rule;
  int max_depth;
};

SplitTree::SplitTree(const split::SplitSearch& rule, std::vector<kdtree::Reference> sample,
                     const geometry::Aabb& box, const kdtree::CellPath& path, int levels,
                     int max_depth, kdtree::BuildCounters& counters) {
  const std::size_t size = sample.size();
  sample.resize(size + scratch_size(size));
  grow({rule, max_depth}, std::span(sample).first(size), sample.data() + size, box, path, levels,
       counters);
}

SplitTree::Child SplitTree::grow(const Growth& growth, std::span<kdtree::Reference> sample,
                                 kdtree::Reference* buffer, const geometry::Aabb& box,
                                 const kdtree::CellPath& path, int levels,
                                 kdtree::BuildCounters& counters) {
  std::optional<kdtree::Split> cut;
  if (levels > 0 && sample.size() >= kLeastSample && path.depth < growth.max_depth) {
    cut = growth.rule.choose({sample, box, path}, counters);
  }
  if (!cut) {
    leaves_.push_back({box, path});
    return {true, leaves_.size() - 1};
  }
  const kdtree::PartitionCounts n = kdtree::sift(sample, *cut, sample.data(), buffer);
  counters.touches += sample.size();
  const geometry::HalvedCell halves = halve(box, cut->plane.axis, cut->plane.position);
  const kdtree::CellPath below = path.below(*cut);
  const std::size_t index = nodes_.size();
  nodes_.push_back({*cut, {}, {}});
  const Child left = grow(growth, sample.first(n.left), buffer + n.right, halves.left, below,
                          levels - 1, counters);
  const Child right =
      grow(growth, {buffer, n.right}, buffer + n.right, halves.right, below, levels - 1, counters);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return {false, index};
}

std::vector<std::shared_ptr<const kdtree::ReferenceList>> SplitTree::divide(
    std::span<kdtree::Reference> refs, kdtree::Reference* buffer,
    kdtree::BuildCounters& counters) const {
  std::vector<std::shared_ptr<const kdtree::ReferenceList>> lists(leaves_.size());
  const auto follow = [&](const auto& self, const Child& child, std::span<kdtree::Reference> list,
                          kdtree::Reference* free) -> void {
    if (child.is_leaf) {
      lists[child.index] =
          std::make_shared<const kdtree::ReferenceList>(std::span<const kdtree::Reference>(list));
      return;
    }
    const Node& node = nodes_[child.index];
    const kdtree::PartitionCounts n = kdtree::sift(list, node.cut, list.data(), free);
    counters.touches += list.size();
    self(self, node.left, list.first(n.left), free + n.right);
    self(self, node.right, {free, n.right}, free + n.right);
  };
  follow(follow, Child{nodes_.empty(), 0}, refs, buffer);
  return lists;
}

}  // namespace sightline::accel::lazy
