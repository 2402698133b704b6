// What finished cells become while a subtree grows: leaves, and the hierarchy above them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "accel/blocks/block_builder.h"
#include "accel/blocks/hierarchy.h"
#include "accel/grow/grow.h"

namespace sightline::accel::grow {

/// What a cell has become: a hierarchy that is not compiled yet, or a slot with its box. Nothing:
/// an empty cell.
struct Grown {
  const blocks::Node* node = nullptr;
  kdtree::Slot slot{};
  geometry::Aabb box{};  ///< Of the slot, in the tree's frame.

  bool is_empty() const { return node == nullptr && !slot; }
};

/// A cell of faces of at most this many references becomes leaf blocks, without further cuts.
inline constexpr std::size_t kBlockCell = 512;

/// The finished cells of one task, in an arena that counts as held by the tree. Faces end in leaf
/// blocks; other references in lists, whose boxes are in the tree's frame. Threads: one.
class Subtrees {
 public:
  explicit Subtrees(const GrowContext& context);
  ~Subtrees();
  Subtrees(const Subtrees&) = delete;
  Subtrees& operator=(const Subtrees&) = delete;

  /// Whether a cell needs no more cuts.
  bool is_leaf(std::size_t references) const { return builder_ && references <= kBlockCell; }
  /// Makes leaves of all references of a cell.
  Grown finish(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell);
  /// A cell that waits. Throws std::bad_alloc.
  Grown leave_over(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                   const kdtree::CellPath& path);

  /// The two sides of a cut. Two hierarchies become one; if a side is a slot, or the hierarchy
  /// would be too deep, each becomes a slot below a node of the tree. Throws std::bad_alloc.
  Grown join(const Grown& left, const Grown& right);

  /// Compiles all that was finished to wide nodes. A hierarchy that has most of many blocks keeps
  /// them where they are. Throws std::bad_alloc.
  kdtree::Slot compile(const Grown& all);

  /// Takes over what another task has finished.
  void take_over(Subtrees& other);

 private:
  geometry::Aabb box_of(const blocks::Node& node) const;
  kdtree::Slot slot_of(const Grown& grown);
  Grown own(kdtree::Slot slot, const geometry::Aabb& box);
  const blocks::Node* list(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell);

  const GrowContext& context_;
  std::optional<blocks::BlockBuilder> builder_;  ///< Of trees over faces.
  blocks::Arena arena_;
  bool gave_words_ = false;  ///< Blocks of hierarchies that remain may belong to a subtree.
  GrowingBytes held_;
  std::vector<kdtree::Slot> owned_;  ///< What no slot leads to yet; it goes if this throws.
};

}  // namespace sightline::accel::grow
