// Compiles binary hierarchies into wide trees: decides what becomes a node, then makes the nodes.
#include "accel/wide/wide_tree.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#include <sys/mman.h>

#include "accel/blocks/block.h"
#include "accel/blocks/frame.h"
#include "accel/kdtree/tree_metrics.h"

namespace sightline::accel::wide {
namespace {

using blocks::Node;
using kdtree::kWidth;
using kdtree::Slot;
using kdtree::WideNode;

constexpr std::size_t kTail = blocks::kBlockSlack;

/// The children of what will be one wide node.
struct Collapsed {
  std::array<const Node*, kWidth> children{};
  /// The index of the entry of each child that is an inner node.
  std::array<std::uint32_t, kWidth> index{};
};

float area(const geometry::Aabb& box) {
  const float x = box.hi.x - box.lo.x, y = box.hi.y - box.lo.y, z = box.hi.z - box.lo.z;
  return x * y + y * z + z * x;
}

/// Chooses the children of a wide node: the two of a binary node, then what is below them, while
/// there is room.
class Children {
 public:
  explicit Children(const Node& node) {
    add(node.left);
    add(node.right);
    // The child that gains most for the slots that it takes is opened first. A subtree with few
    // leaves is replaced by all of them if there is room, and needs no node.
    while (open(best([&](const Node& child) { return gain(child); }))) {
    }
    // Slots that are left go to the largest children with a leaf directly below.
    while (count_ < kWidth && open(best([](const Node& child) {
             const bool with_leaf = !child.leaf() && (child.left->leaf() || child.right->leaf());
             return with_leaf ? area(child.box) : 0;
           }))) {
    }
  }

  const std::array<const Node*, kWidth>& nodes() const { return nodes_; }

 private:
  void add(const Node* child) {
    assert(count_ < kWidth);
    nodes_[count_++] = child;
  }

  /// The index of the child with the largest value, if that is positive; else kWidth.
  template <class Value>
  std::size_t best(const Value& value) const {
    std::size_t best = kWidth;
    float most = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const float of_child = value(*nodes_[i]);
      if (!(of_child > most)) continue;
      most = of_child;
      best = i;
    }
    return best;
  }

  /// The area of the child's box, which rays need not meet first once it is opened, for each slot
  /// that opening takes.
  float gain(const Node& child) const {
    if (child.leaf()) return 0;
    const std::size_t more = child.leaves > kWidth ? 1 : child.leaves - std::size_t{1};
    return more <= kWidth - count_ ? area(child.box) / static_cast<float>(more) : 0;
  }

  bool open(std::size_t i) {
    if (i == kWidth) return false;
    const Node& opened = *nodes_[i];
    nodes_[i] = nodes_[--count_];
    if (opened.leaves <= kWidth && opened.leaves <= kWidth - count_) {
      add_leaves(opened);
    } else {
      add(opened.left);
      add(opened.right);
    }
    return true;
  }

  void add_leaves(const Node& node) {
    if (node.leaf()) return add(&node);
    add_leaves(*node.left);
    add_leaves(*node.right);
  }

  std::array<const Node*, kWidth> nodes_{};
  std::size_t count_ = 0;
};

class Collapse {
 public:
  explicit Collapse(const Node& root) {
    if (root.leaf()) {
      words_ = root.words;
    } else {
      add(root);
    }
  }

  const std::vector<Collapsed>& nodes() const { return nodes_; }
  std::size_t words() const { return words_; }

 private:
  std::uint32_t add(const Node& node) {
    const std::size_t at = nodes_.size();
    nodes_.push_back({Children(node).nodes()});
    for (std::size_t i = 0; i < kWidth; ++i) {
      const Node* child = nodes_[at].children[i];
      if (child == nullptr) break;
      words_ += child->words;
      if (child->leaf()) continue;
      const std::uint32_t index = add(*child);
      nodes_[at].index[i] = index;
    }
    return static_cast<std::uint32_t>(at);
  }

  std::vector<Collapsed> nodes_;
  std::size_t words_ = 0;
};

/// Allocates memory, aligned to huge pages where they save address translations.
std::byte* allocate(std::size_t bytes) {
  const bool huge = bytes >= 4 * blocks::kHugePage;
  const std::size_t alignment = huge ? blocks::kHugePage : alignof(WideNode);
  void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  if (huge) madvise(memory, bytes, MADV_HUGEPAGE);
  return static_cast<std::byte*>(memory);
}

/// Makes the slots of leaves. Copies their words one behind the other to `copies`, unless that is
/// null.
class Leaves {
 public:
  Leaves(LeafKind kind, std::uint32_t* copies) : kind_(kind), next_(copies) {}

  Slot slot(const Node& leaf) {
    const std::uint32_t* words = leaf.leaf_words;
    if (next_ != nullptr) {
      std::memcpy(next_, words, leaf.words * sizeof(std::uint32_t));
      words = std::exchange(next_, next_ + leaf.words);
    }
    return kind_ == LeafKind::kLists ? Slot::list(words) : Slot::block(words);
  }

 private:
  const LeafKind kind_;
  std::uint32_t* next_;
};

/// The box relative to the center. This is exact: the bounds of the tree are within a factor of two
/// of the center, or that is 0.
geometry::Aabb relative(geometry::Aabb box, const geometry::Vec3f& center) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = blocks::relative(box.lo[axis], center[axis]);
    box.hi[axis] = blocks::relative(box.hi[axis], center[axis]);
  }
  return box;
}

/// Calls visit(leaf) for every leaf below.
template <class Visit>
void each_leaf(Slot at, const Visit& visit) {
  if (!at) return;
  if (!at.is_node()) return visit(at);
  for (const kdtree::AtomicSlot& child : at.node()->children) each_leaf(kdtree::load(child), visit);
}

std::size_t size_of(Slot leaf) {
  return leaf.is_list() ? leaf.list().size() : blocks::Block(leaf.words()).triangles;
}

/// Calls visit(id) for every reference of a leaf.
template <class Visit>
void each_id(Slot leaf, const Visit& visit) {
  if (leaf.is_list()) {
    for (const std::uint32_t id : leaf.list()) visit(id);
    return;
  }
  const blocks::Block block(leaf.words());
  for (std::size_t i = 0; i < block.triangles; ++i) visit(block.id(i));
}

/// Adds the metrics below a slot. A random line that meets the tree's bounds meets this box with
/// probability `share`.
void measure_below(Slot at, double share, double root_area, int depth, kdtree::TreeMetrics& m) {
  if (!at) return;
  ++m.nodes;
  if (!at.is_node()) {
    ++m.leaves;
    ++m.nonempty_leaves;
    m.references += size_of(at);
    m.max_depth = std::max(m.max_depth, depth);
    m.expected_leaves += share;
    m.expected_intersections += share * static_cast<double>(size_of(at));
    return;
  }
  m.expected_traversals += share;
  for (std::size_t i = 0; i < kWidth; ++i) {
    const double part = root_area > 0 ? half_area(at.node()->box(i)) / root_area : 1;
    measure_below(at.node()->child(i), part, root_area, depth + 1, m);
  }
}

}  // namespace

void WideTree::Free::operator()(std::byte* memory) const { std::free(memory); }

WideTree::WideTree(const Node& root, const geometry::Vec3f& center, LeafKind kind)
    : WideTree(root, center, kind, blocks::Chunks(0), true) {}

WideTree::WideTree(const Node& root, const geometry::Vec3f& center, blocks::Chunks words)
    : WideTree(root, center, LeafKind::kBlocks, std::move(words), false) {}

WideTree::WideTree(const Node& root, const geometry::Vec3f& center, LeafKind kind,
                   blocks::Chunks words, bool copies)
    : center_(center), box_(root.box), words_(std::move(words)) {
  assert(root.levels <= kdtree::kMostLevels);
  const Collapse collapse(root);
  node_count_ = collapse.nodes().size();
  const std::size_t copied = copies ? collapse.words() * sizeof(std::uint32_t) + kTail : 0;
  bytes_ = std::max<std::size_t>(node_count_ * sizeof(WideNode) + copied, 1);
  memory_.reset(allocate(bytes_));
  auto* nodes = reinterpret_cast<WideNode*>(memory_.get());
  if (copies) std::memset(memory_.get() + bytes_ - kTail, 0, kTail);
  Leaves leaves(kind, copies ? reinterpret_cast<std::uint32_t*>(nodes + node_count_) : nullptr);
  if (root.leaf()) {
    root_ = leaves.slot(root);
    return;
  }
  root_ = Slot::final_node(nodes);
  for (std::size_t at = 0; at < node_count_; ++at) {
    const Collapsed& from = collapse.nodes()[at];
    auto* node = new (nodes + at) WideNode;
    for (std::size_t i = 0; i < kWidth && from.children[i] != nullptr; ++i) {
      const Node& child = *from.children[i];
      node->set_box(i, relative(child.box, center));
      const Slot below =
          child.leaf() ? leaves.slot(child) : Slot::final_node(nodes + from.index[i]);
      node->children[i].store(below.bits(), std::memory_order_relaxed);
    }
  }
}

std::uint64_t WideTree::size_in_bytes() const { return sizeof(*this) + bytes_ + words_.bytes(); }

std::vector<std::uint32_t> WideTree::ids() const {
  std::vector<std::uint32_t> ids;
  each_leaf(root_, [&](Slot leaf) { each_id(leaf, [&](std::uint32_t id) { ids.push_back(id); }); });
  return ids;
}

void WideTree::measure(double root_area, int depth, kdtree::TreeMetrics& metrics) const {
  double share = 1;
  if (root_.is_node() && root_area > 0) {
    geometry::Aabb box;
    for (std::size_t i = 0; i < kWidth && root_.node()->child(i); ++i)
      box.grow(root_.node()->box(i));
    share = half_area(box) / root_area;
  }
  measure_below(root_, share, root_area, depth, metrics);
}

void WideTree::measure_growth(std::vector<bool>& seen, kdtree::GrowthMetrics& growth) const {
  growth.cells_built += node_count_;
  each_leaf(root_, [&](Slot leaf) {
    ++growth.cells_built;
    each_id(leaf, [&](std::uint32_t id) {
      if (seen[id]) return;
      seen[id] = true;
      ++growth.references_built;
    });
  });
}

}  // namespace sightline::accel::wide
