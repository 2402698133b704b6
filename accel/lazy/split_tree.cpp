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

std::vector<std::size_t> sample_places(std::size_t size) {
  const std::size_t stretch = std::max(kStretch, size / kMostSample);
  std::vector<std::size_t> places(size / stretch);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::size_t mixed = (k + 1) * std::size_t{0x9e3779b97f4a7c15u} >> 32;
    places[k] = k * stretch + mixed % stretch;
  }
  return places;
}

struct CutTree::Growth {
  const split::SplitSearch& rule;
  int max_depth;
};

CutTree::CutTree(const split::SplitSearch& rule, std::vector<kdtree::BoxRef> sample,
                 const geometry::Aabb& box, const kdtree::CellPath& path, int levels, int max_depth,
                 kdtree::BuildCounters& counters) {
  const std::size_t size = sample.size();
  sample.resize(size + room(size));
  grow({rule, max_depth}, std::span(sample).first(size), sample.data() + size, box, path, levels,
       counters);
}

CutTree::Child CutTree::grow(const Growth& growth, std::span<kdtree::BoxRef> sample,
                             kdtree::BoxRef* room, const geometry::Aabb& box,
                             const kdtree::CellPath& path, int levels,
                             kdtree::BuildCounters& counters) {
  std::optional<kdtree::Cut> cut;
  if (levels > 0 && sample.size() >= kLeastSample && path.depth < growth.max_depth) {
    cut = growth.rule.choose({sample, box, path}, counters);
  }
  if (!cut) {
    parts_.push_back({box, path});
    return {true, parts_.size() - 1};
  }
  const kdtree::Sifted n = kdtree::sift(sample, *cut, sample.data(), room);
  counters.touches += sample.size();
  const geometry::HalvedCell halves = halve(box, cut->plane.axis, cut->plane.position);
  const kdtree::CellPath below = path.below(*cut);
  const std::size_t place = nodes_.size();
  nodes_.push_back({*cut, {}, {}});
  const Child left =
      grow(growth, sample.first(n.left), room + n.right, halves.left, below, levels - 1, counters);
  const Child right =
      grow(growth, {room, n.right}, room + n.right, halves.right, below, levels - 1, counters);
  nodes_[place].left = left;
  nodes_[place].right = right;
  return {false, place};
}

std::vector<std::shared_ptr<const kdtree::BoxList>> CutTree::divide(
    std::span<kdtree::BoxRef> refs, kdtree::BoxRef* room, kdtree::BuildCounters& counters) const {
  std::vector<std::shared_ptr<const kdtree::BoxList>> lists(parts_.size());
  const auto follow = [&](const auto& self, const Child& child, std::span<kdtree::BoxRef> list,
                          kdtree::BoxRef* free) -> void {
    if (child.is_part) {
      lists[child.place] =
          std::make_shared<const kdtree::BoxList>(std::span<const kdtree::BoxRef>(list));
      return;
    }
    const Node& node = nodes_[child.place];
    const kdtree::Sifted n = kdtree::sift(list, node.cut, list.data(), free);
    counters.touches += list.size();
    self(self, node.left, list.first(n.left), free + n.right);
    self(self, node.right, {free, n.right}, free + n.right);
  };
  follow(follow, Child{nodes_.empty(), 0}, refs, room);
  return lists;
}

}  // namespace sightline::accel::lazy
