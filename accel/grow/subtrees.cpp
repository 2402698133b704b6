// What finished cells become while a subtree grows: leaves, and the hierarchy above them.
#include "accel/grow/subtrees.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "accel/wide/wide_tree.h"

namespace sightline::accel::grow {
namespace {

std::size_t bytes_of_words(const blocks::Node& node) {
  return node.leaf() ? node.words * sizeof(std::uint32_t)
                     : bytes_of_words(*node.left) + bytes_of_words(*node.right);
}

}  // namespace

Subtrees::Subtrees(const GrowContext& context) : context_(context), held_(context.tree) {
  if (context.mesh != nullptr) builder_.emplace(*context.mesh, context.frame.center);
}

Subtrees::~Subtrees() {
  for (const kdtree::Slot slot : owned_) context_.tree.discard(slot);
}

Grown Subtrees::finish(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell) {
  if (refs.empty()) return {};
  const blocks::Node* node = builder_ ? builder_->build(refs, cell, arena_) : list(refs, cell);
  held_.reach(arena_.bytes());
  return {.node = node};
}

const blocks::Node* Subtrees::list(std::span<const kdtree::Reference> refs,
                                   const geometry::Aabb& cell) {
  blocks::Node* const leaf = arena_.node();
  leaf->words = static_cast<std::uint32_t>(refs.size() + 1);
  std::uint32_t* words = arena_.words(leaf->words);
  leaf->leaf_words = words;
  *words = static_cast<std::uint32_t>(refs.size());
  for (const kdtree::Reference& ref : refs) {
    *++words = ref.id;
    leaf->box.grow(in_frame(context_.frame, geometry::common(ref.bounds(), cell)));
  }
  return leaf;
}

Grown Subtrees::leave_over(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                           const kdtree::CellPath& path) {
  owned_.reserve(owned_.size() + 1);
  return own(context_.tree.leave_over(kdtree::ReferenceList(refs), cell, path),
             in_frame(context_.frame, cell));
}

Grown Subtrees::own(kdtree::Slot slot, const geometry::Aabb& box) {
  owned_.push_back(slot);
  return {.slot = slot, .box = box};
}

Grown Subtrees::join(const Grown& left, const Grown& right) {
  if (left.is_empty()) return right;
  if (right.is_empty()) return left;
  if (left.node != nullptr && right.node != nullptr &&
      std::max(left.node->levels, right.node->levels) < kdtree::kMostLevels)
    return {.node = arena_.join(left.node, right.node)};
  owned_.reserve(owned_.size() + 1);
  kdtree::WideNode* const node = context_.tree.make_node();
  owned_.push_back(kdtree::Slot::node(node));
  geometry::Aabb box;
  for (std::size_t i = 0; i < 2; ++i) {
    const Grown& side = i == 0 ? left : right;
    const geometry::Aabb of_side = side.node != nullptr ? box_of(*side.node) : side.box;
    node->set_box(i, of_side);
    box.grow(of_side);
    const kdtree::Slot below = slot_of(side);
    std::erase(owned_, below);
    node->children[i].store(below.bits(), std::memory_order_relaxed);
  }
  return {.slot = kdtree::Slot::node(node), .box = box};
}

geometry::Aabb Subtrees::box_of(const blocks::Node& node) const {
  return builder_ ? in_frame(context_.frame, node.box) : node.box;
}

kdtree::Slot Subtrees::slot_of(const Grown& grown) {
  // Copies of smaller hierarchies take no space that is not used.
  constexpr std::size_t kLarge = std::size_t{1} << 14;
  if (grown.node == nullptr) return grown.slot;
  const std::size_t bytes = arena_.bytes_of_words();
  std::unique_ptr<wide::WideTree> tree;
  if (!builder_) {
    tree = std::make_unique<wide::WideTree>(*grown.node, geometry::Vec3f{}, wide::LeafKind::kLists);
  } else if (gave_words_ || bytes < kLarge || 2 * bytes_of_words(*grown.node) < bytes) {
    tree = std::make_unique<wide::WideTree>(*grown.node, context_.frame.center);
  } else {
    gave_words_ = true;
    tree =
        std::make_unique<wide::WideTree>(*grown.node, context_.frame.center, arena_.take_words());
    held_.shrink(held_.bytes() - std::min<std::uint64_t>(bytes, held_.bytes()));
  }
  return context_.tree.finish(std::move(tree));
}

kdtree::Slot Subtrees::compile(const Grown& all) {
  if (all.is_empty()) return kdtree::Slot::empty_list();
  const kdtree::Slot slot = slot_of(all);
  owned_.clear();
  return slot;
}

void Subtrees::take_over(Subtrees& other) {
  owned_.insert(owned_.end(), other.owned_.begin(), other.owned_.end());
  other.owned_.clear();
  gave_words_ |= other.gave_words_;
  arena_.append(std::move(other.arena_));
  other.held_.shrink(0);
  held_.reach(arena_.bytes());
}

}  // namespace sightline::accel::grow
