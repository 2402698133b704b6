// Grows a few splits over a sample, and sifts each slice by all of them while it is in the cache.
#include "accel/lazy/split_tree.h"

#include <algorithm>

#include "accel/kdtree/sift.h"

namespace sightline::accel::lazy {
namespace {

/// A sample takes one reference in kInterval, and at most kMostSample.
constexpr std::size_t kInterval = 16;
constexpr std::size_t kMostSample = 4096;

/// Smaller samples do not give the cost of a split well enough.
constexpr std::size_t kLeastSample = 256;

}  // namespace

std::vector<std::size_t> sample_indices(std::size_t size) {
  const std::size_t interval = std::max(kInterval, size / kMostSample);
  std::vector<std::size_t> indices(size / interval);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const std::size_t mixed = (k + 1) * std::size_t{0x9e3779b97f4a7c15u} >> 32;
    indices[k] = k * interval + mixed % interval;
  }
  return indices;
}

struct SplitTree::Growth {
  const split::SplitSearch& rule;
  int max_depth;
  std::size_t& in_leaves;  ///< References in the leaves so far.
};

SplitTree::SplitTree(const split::SplitSearch& rule, std::vector<kdtree::Reference> sample,
                     const geometry::Aabb& box, const kdtree::CellPath& path, int levels,
                     int max_depth, kdtree::BuildCounters& counters) {
  const std::size_t size = sample.size();
  sample.resize(size + scratch_size(size));
  std::size_t in_leaves = 0;
  grow({rule, max_depth, in_leaves}, std::span(sample).first(size), sample.data() + size, box, path,
       levels, counters);
  if (size > 0)
    duplication_ = std::max(1.0, static_cast<double>(in_leaves) / static_cast<double>(size));
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
    growth.in_leaves += sample.size();
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
