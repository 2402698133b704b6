// A few levels of splits, chosen from a sample of a long list. The list is divided by all of them
// in one pass.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// Lists of at least this many references are split by a sample, if the rule takes samples.
inline constexpr std::size_t kSampleFrom = 8192;

/// Indices of a sample of a list of that length (at least kSampleFrom), ascending: a pseudo-random
/// one in each of many intervals of equal length.
std::vector<std::size_t> sample_indices(std::size_t size);

/// The topmost splits of a cell, as a small tree.
class SplitTree {
 public:
  static constexpr int kMostLevels = 3;

  /// One side of a split: another split, or a leaf.
  struct Child {
    bool is_leaf = true;
    std::size_t index = 0;  ///< Index in nodes() or leaves().
  };
  struct Node {
    kdtree::Split cut;
    Child left, right;
  };
  struct Leaf {
    geometry::Aabb box;
    kdtree::CellPath path;
  };

  /// Splits the sample where the rule would, while the sample is large enough.
  SplitTree(const split::SplitSearch& rule, std::vector<kdtree::Reference> sample,
            const geometry::Aabb& box, const kdtree::CellPath& path, int levels, int max_depth,
            kdtree::BuildCounters& counters);

  /// Nothing is split.
  bool empty() const { return nodes_.empty(); }
  /// References of the sample in all leaves, for each one of the sample: 1 or more.
  double duplication() const { return duplication_; }
  std::span<const Leaf> leaves() const { return leaves_; }

  /// Capacity of the buffer that divide() needs for a list of that length.
  static std::size_t scratch_size(std::size_t size) { return size * kMostLevels; }

  /// Divides some of the cell's references; `refs` is overwritten. Returns a list for every leaf.
  std::vector<std::shared_ptr<const kdtree::ReferenceList>> divide(
      std::span<kdtree::Reference> refs, kdtree::Reference* buffer,
      kdtree::BuildCounters& counters) const;

 private:
  struct Growth;
  Child grow(const Growth& growth, std::span<kdtree::Reference> sample, kdtree::Reference* buffer,
             const geometry::Aabb& box, const kdtree::CellPath& path, int levels,
             kdtree::BuildCounters& counters);

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  double duplication_ = 1;
};

}  // namespace sightline::accel::lazy
