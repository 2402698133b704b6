// What all cells of a tree share.
#include "accel/lazy/tree_context.h"

#include <utility>

#include "accel/grow/reference_budget.h"
#include "accel/grow/subtrees.h"

namespace sightline::accel::lazy {
namespace {

/// Faces end in leaf blocks, unless floats are too coarse or too short for their sizes.
bool may_make_blocks(const geometry::MeshView* mesh, const geometry::Aabb& bounds) {
  return mesh != nullptr && !bounds.empty() && wide::frame_of(bounds).scale == 1;
}

}  // namespace

TreeContext::TreeContext(const geometry::Aabb& bounds, std::size_t references,
                         split::SplitRule split_rule, ReferenceSource from,
                         const geometry::MeshView* faces_of,
                         std::shared_ptr<kdtree::TreeMemory> memory)
    : rule(std::move(split_rule)),
      source(std::make_shared<const ReferenceSource>(std::move(from))),
      mesh(faces_of),
      size(references),
      max_depth(grow::depth_limit(references)),
      frame(wide::frame_of(bounds)),
      makes_blocks(may_make_blocks(mesh, bounds)),
      is_list(mesh != nullptr && !bounds.empty() && !makes_blocks),
      tree(bounds, references, grow::root_path(budget(), references), std::move(memory)) {}

bool TreeContext::is_eager(const kdtree::DeferredCell& cell) const {
  if (!makes_blocks) return cell.weight <= kEagerBelow;
  return cell.weight <= (cell.size == size ? kWholeMesh : grow::kBlockCell);
}

bool TreeContext::may_grow(const kdtree::DeferredCell& cell) const {
  if (is_list) return false;
  if (tree.memory() == nullptr || tree.memory()->may_grow()) return true;
  return is_evictable() && cell.has_list && !cell.list.is_compact() &&
         cell.list.size() >= kdtree::kLongList;
}

}  // namespace sightline::accel::lazy
