// Nodes and leaves of a hierarchy under construction.
#include "accel/published/bvh/bvh_growth.h"

#include <algorithm>

namespace sightline::accel::published::bvh {
namespace {

/// Copies the nodes and ids below a node, in depth-first order.
class Flattening {
 public:
  Flattening(const BvhNode* nodes, const std::uint32_t* ids, Bvh& out)
      : nodes_(nodes), ids_(ids), out_(out) {}

  BvhChild copy(const BvhChild& from) {
    BvhChild to = from;
    if (!from.inner) {
      to.first = static_cast<std::uint32_t>(out_.ids.size());
      out_.ids.insert(out_.ids.end(), ids_ + from.first, ids_ + from.first + from.count);
      return to;
    }
    const std::size_t index = out_.nodes.size();
    to.first = static_cast<std::uint32_t>(index);
    out_.nodes.emplace_back();
    for (const std::size_t side : {0u, 1u}) {
      const BvhChild child = copy(nodes_[from.first].child(side));
      out_.nodes[index].set(side, child);
    }
    return to;
  }

 private:
  const BvhNode* nodes_;
  const std::uint32_t* ids_;
  Bvh& out_;
};

}  // namespace

BvhGrowth::BvhGrowth(std::size_t references, bool repeats)
    : nodes_(references), ids_(references), repeats_(repeats) {}

BvhChild BvhGrowth::leaf(std::span<const kdtree::Reference> refs, const geometry::Aabb& box) {
  const std::size_t first = ids_used_.fetch_add(refs.size(), std::memory_order_relaxed);
  std::uint32_t* const begin = ids_.data() + first;
  std::uint32_t* end = begin;
  for (const kdtree::Reference& ref : refs) {
    if (repeats_ || std::find(begin, end, ref.id) == end) *end++ = ref.id;
  }
  return {.box = box,
          .first = static_cast<std::uint32_t>(first),
          .count = static_cast<std::uint32_t>(end - begin)};
}

BvhChild BvhGrowth::inner(const BvhChild& left, const BvhChild& right) {
  const std::size_t index = nodes_used_.fetch_add(1, std::memory_order_relaxed);
  BvhNode& node = nodes_.data()[index];
  node.set(0, left);
  node.set(1, right);
  geometry::Aabb box = left.box;
  box.grow(right.box);
  return {.box = box, .first = static_cast<std::uint32_t>(index), .inner = true};
}

Bvh BvhGrowth::finish(const BvhChild& root) const {
  Bvh bvh;
  bvh.nodes.reserve(nodes_used_.load(std::memory_order_relaxed));
  bvh.ids.reserve(ids_used_.load(std::memory_order_relaxed));
  bvh.root = Flattening(nodes_.data(), ids_.data(), bvh).copy(root);
  return bvh;
}

}  // namespace sightline::accel::published::bvh
