// Grows a few splits over a sample, and sifts each slice by all of them while it is in the cache.
#include "accel/lazy/split_tree.h"

#include <algorithm>
#include <cmath>

#include "accel/grow/reference_budget.h"
#include "accel/kdtree/sift.h"

namespace sightline::accel::lazy {
namespace {

/// A sample takes one reference in kInterval, and at most kMostSample.
constexpr std::size_t kInterval = 16;
constexpr std::size_t kMostSample = 4096;

/// Smaller samples do not give the cost of a split well enough.
constexpr std::size_t kLeastSample = 256;

/// Indices of a sample of a list of that length, ascending: a pseudo-random one in each of many
/// intervals of equal length.
std::vector<std::size_t> sample_indices(std::size_t size) {
  const std::size_t interval = std::max(kInterval, size / kMostSample);
  std::vector<std::size_t> indices(size / interval);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const std::size_t mixed = (k + 1) * std::size_t{0x9e3779b97f4a7c15u} >> 32;
    indices[k] = k * interval + mixed % interval;
  }
  return indices;
}

}  // namespace

struct SplitTree::Growth {
  const split::SplitSearch& rule;
  int max_depth;
  kdtree::BuildCounters& counters;
  std::size_t in_leaves = 0;  ///< References in the leaves so far.
};

SplitTree SplitTree::of_sample(const split::SplitSearch& rule, const CellReader& references,
                               const geometry::Aabb& box, const kdtree::CellPath& path,
                               int max_depth, kdtree::BuildCounters& counters) {
  constexpr double kMostPerLevel = 1.1;
  const std::vector<kdtree::Reference> sample =
      references.pick(sample_indices(references.size()), counters);
  const auto size = static_cast<double>(references.size());
  for (int levels = kMostLevels;; --levels) {
    SplitTree cuts;
    Growth growth{rule, max_depth, counters};
    std::vector<kdtree::Reference> lists = sample;
    lists.resize(sample.size() + scratch_size(sample.size()));
    cuts.grow(growth, std::span(lists).first(sample.size()), lists.data() + sample.size(),
              {box, path}, levels);
    double duplication = 1;
    if (!sample.empty())
      duplication =
          std::max(1.0, static_cast<double>(growth.in_leaves) / static_cast<double>(sample.size()));
    const bool separates = duplication <= std::pow(kMostPerLevel, levels);
    if (levels == 0 || (separates && grow::within_budget(path, size, size * (duplication - 1))))
      return cuts;
  }
}

SplitTree::Child SplitTree::grow(Growth& growth, std::span<kdtree::Reference> sample,
                                 kdtree::Reference* buffer, const Leaf& cell, int levels) {
  std::optional<kdtree::Split> cut;
  if (levels > 0 && sample.size() >= kLeastSample && cell.path.depth < growth.max_depth) {
    cut = growth.rule.choose({sample, cell.box, cell.path}, growth.counters);
  }
  if (!cut) {
    growth.in_leaves += sample.size();
    leaves_.push_back(cell);
    return {true, leaves_.size() - 1};
  }
  const kdtree::PartitionCounts n = kdtree::sift(sample, *cut, sample.data(), buffer);
  growth.counters.touches += sample.size();
  const geometry::HalvedCell halves = halve(cell.box, cut->plane.axis, cut->plane.position);
  const kdtree::CellPath below = cell.path.below(*cut);
  const std::size_t index = nodes_.size();
  nodes_.push_back({*cut, {}, {}});
  kdtree::Reference* const free = buffer + n.right;
  const Child left = grow(growth, sample.first(n.left), free, {halves.left, below}, levels - 1);
  const Child right = grow(growth, {buffer, n.right}, free, {halves.right, below}, levels - 1);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return {false, index};
}

std::vector<ListPart> SplitTree::sift(std::span<kdtree::Reference> refs, kdtree::Reference* buffer,
                                      kdtree::BuildCounters& counters) const {
  std::vector<ListPart> lists(leaves_.size());
  const auto follow = [&](const auto& self, const Child& child, std::span<kdtree::Reference> list,
                          kdtree::Reference* free) -> void {
    if (child.is_leaf) {
      ListPart& part = lists[child.index];
      part.list = kdtree::ReferenceList(std::span<const kdtree::Reference>(list));
      part.bounds = kdtree::bounds_of(list);  // while it is in the cache
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
