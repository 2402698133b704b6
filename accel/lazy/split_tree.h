// A few cuts at once, chosen from a sample of a long list. One pass divides the list by all of
// them.
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

/// The indices of a sample of a list of `size` references (at least kSampleFrom): one in each block
/// of equal length, at a mixed offset, so that the sample follows no order of the list. Ascending.
std::vector<std::size_t> sample_places(std::size_t size);

/// The topmost cuts of a cell.
class CutTree {
 public:
  static constexpr int kMostLevels = 3;

  /// A cut's side: another cut, or a part of the list.
  struct Child {
    bool is_part = true;
    std::size_t place = 0;  ///< In cuts() or parts().
  };
  struct Node {
    kdtree::Cut cut;
    Child left, right;
  };
  struct Part {
    geometry::Aabb box;
    kdtree::CellPath path;
  };

  /// Cuts the sample by the rule, as long as enough of it is left to be representative.
  CutTree(const split::SplitSearch& rule, std::vector<kdtree::BoxRef> sample,
          const geometry::Aabb& box, const kdtree::CellPath& path, int levels, int max_depth,
          kdtree::BuildCounters& counters);

  bool empty() const { return nodes_.empty(); }
  std::span<const Node> nodes() const { return nodes_; }  ///< The first is the topmost.
  std::span<const Part> parts() const { return parts_; }

  /// Room that divide() needs behind a list.
  static std::size_t room(std::size_t size) { return size * kMostLevels; }

  /// Divides some of the cell's references and overwrites them. Returns a list for each part.
  std::vector<std::shared_ptr<const kdtree::BoxList>> divide(std::span<kdtree::BoxRef> refs,
                                                             kdtree::BoxRef* room,
                                                             kdtree::BuildCounters& counters) const;

 private:
  struct Growth;
  Child grow(const Growth& growth, std::span<kdtree::BoxRef> sample, kdtree::BoxRef* room,
             const geometry::Aabb& box, const kdtree::CellPath& path, int levels,
             kdtree::BuildCounters& counters);

  std::vector<Node> nodes_;
  std::vector<Part> parts_;
};

}  // namespace sightline::accel::lazy
