// The boxes of the cells of a lazy tree that are not built yet.
#include "accel/kdtree/deferred_boxes.h"

namespace sightline::accel::kdtree {
namespace {

void pass_below(const KdTree& tree, Slot slot,
                const std::function<void(const geometry::Aabb&)>& pass) {
  if (slot.is_deferred()) return pass(slot.cell()->box);
  if (slot.is_finished() || slot.is_leaf()) return;
  const AtomicSlot* children = tree.children(slot);
  pass_below(tree, load(children[0]), pass);
  pass_below(tree, load(children[1]), pass);
}

}  // namespace

void for_each_deferred_box(const KdTree& tree,
                           const std::function<void(const geometry::Aabb&)>& pass) {
  pass_below(tree, load(tree.root()), pass);
}

}  // namespace sightline::accel::kdtree
