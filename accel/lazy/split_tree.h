// A few levels of splits, chosen from a sample of a long list. The list is divided by all of them
// in one pass.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "accel/lazy/cell_reader.h"
#include "accel/lazy/passes.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// Lists of at least this many references are split by a sample, if the rule takes samples.
inline constexpr std::size_t kSampleFrom = 8192;

/// The topmost splits of a cell, as a small tree. Immutable once it is made. Threads: any.
class SplitTree {
 public:
  struct Leaf {
    geometry::Aabb box;
    kdtree::CellPath path;
  };

  /// Splits a sample of a cell's references, of which there are kSampleFrom or more, where the rule
  /// would: as many levels as the cell's budget and its room for lists allow, and no more than are
  /// good without clipping, which single cuts can do. Throws std::bad_alloc.
  static SplitTree of_sample(const split::SplitSearch& rule, const CellReader& references,
                             const geometry::Aabb& box, const kdtree::CellPath& path, int max_depth,
                             kdtree::BuildCounters& counters);

  /// Nothing is split.
  bool empty() const { return nodes_.empty(); }
  std::span<const Leaf> leaves() const { return leaves_; }

  /// Capacity of the buffer that sift() needs for a list of that length.
  static std::size_t scratch_size(std::size_t size) { return size * kMostLevels; }

  /// Divides some of the cell's references; `refs` is overwritten. Returns a list for every leaf.
  /// Throws std::bad_alloc.
  std::vector<ListPart> sift(std::span<kdtree::Reference> refs, kdtree::Reference* buffer,
                             kdtree::BuildCounters& counters) const;

 private:
  static constexpr int kMostLevels = 3;

  /// One side of a split: another split, or a leaf.
  struct Child {
    bool is_leaf = true;
    std::size_t index = 0;  ///< Index in nodes_ or leaves_.
  };
  struct Node {
    kdtree::Split cut;
    Child left, right;
  };
  struct Growth;
  Child grow(Growth& growth, std::span<kdtree::Reference> sample, kdtree::Reference* buffer,
             const Leaf& cell, int levels);

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
};

}  // namespace sightline::accel::lazy
