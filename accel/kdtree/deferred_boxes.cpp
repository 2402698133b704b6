// The boxes of the cells of a lazy tree that are not built yet.
#include "accel/kdtree/deferred_boxes.h"

namespace sightline::accel::kdtree {
namespace {

void pass_below(Slot slot, const std::function<void(const geometry::Aabb&)>& pass) {
  if (slot.is_deferred()) return pass(slot.cell()->box);
  if (!slot.is_node()) return;
  for (const AtomicSlot& child : slot.node()->children) pass_below(load(child), pass);
}

}  // namespace

void for_each_deferred_box(const KdTree& tree,
                           const std::function<void(const geometry::Aabb&)>& pass) {
  pass_below(load(tree.root()), pass);
}

}  // namespace sightline::accel::kdtree
