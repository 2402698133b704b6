// A few cuts at once, chosen from a sample of a long list, and dividing the list by them in one go.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// Lists of at least this many references are cut by samples, by rules that take them.
inline constexpr std::size_t kSampleFrom = 8192;

/// Places in a list of that length (at least kSampleFrom): one in every stretch of equal length,
/// at a place in it that follows no order a list might have. Ascending.
std::vector<std::size_t> sample_indices(std::size_t size);

/// The topmost cuts of a cell.
class SplitTree {
 public:
  static constexpr int kMostLevels = 3;

  /// A cut's side: another cut, or a part of the list.
  struct Child {
    bool is_leaf = true;
    std::size_t index = 0;  ///< In nodes() or leaves().
  };
  struct Node {
    kdtree::Split cut;
    Child left, right;
  };
  struct Leaf {
    geometry::Aabb box;
    kdtree::CellPath path;
  };

  /// Cuts where the builder would cut the sample, as long as there is enough of it to tell.
  SplitTree(const split::SplitSearch& rule, std::vector<kdtree::Reference> sample,
            const geometry::Aabb& box, const kdtree::CellPath& path, int levels, int max_depth,
            kdtree::BuildCounters& counters);

  bool empty() const { return nodes_.empty(); }
  std::span<const Node> nodes() const { return nodes_; }  ///< The first is the topmost.
  std::span<const Leaf> leaves() const { return leaves_; }

  /// Room that divide() needs behind a list.
  static std::size_t scratch_size(std::size_t size) { return size * kMostLevels; }

  /// Divides some of the cell's references, which are used up. A list for every part.
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
};

}  // namespace sightline::accel::lazy
