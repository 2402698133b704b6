// Sums over the static half, from the movers up, and over the dynamic half.
#include "scenegraph/instances/mobility_view.h"

#include <algorithm>
#include <map>

#include "scenegraph/hierarchy/wide_sum.h"

namespace sightline::scenegraph::instances {
namespace {

std::size_t depth(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  std::size_t depth = 0;
  for (; id != 0; id = hierarchy.find(id)->parent) ++depth;
  return depth;
}

/// What the node brings to the whole scene, in world space.
hierarchy::Subtree part_in_world(const hierarchy::Hierarchy& hierarchy, const model::Node& node) {
  hierarchy::Subtree part = part_in_parent(node, hierarchy.subtree(node));
  for (model::NodeId above = node.parent; above != 0; above = hierarchy.find(above)->parent)
    part = carried(hierarchy.find(above)->parent_from_local, part);
  return part;
}

}  // namespace

bool is_moving(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  if (hierarchy.movers.size() == 0) return false;
  while (id != 0 && hierarchy.movers.find(id) == nullptr) id = hierarchy.find(id)->parent;
  return id != 0;
}

std::vector<model::NodeId> topmost_movers(const hierarchy::Hierarchy& hierarchy) {
  std::vector<model::NodeId> movers;
  movers.reserve(hierarchy.movers.size());
  hierarchy.movers.for_each([&](model::NodeId id, bool) {
    if (!is_moving(hierarchy, hierarchy.find(id)->parent)) movers.push_back(id);
  });
  return movers;
}

HalfView::HalfView(Half half, const hierarchy::Hierarchy& hierarchy)
    : hierarchy_(hierarchy), half_(half), movers_(topmost_movers(hierarchy)) {
  if (half == Half::kDynamic) {
    for (const model::NodeId id : movers_)
      include(all_, part_in_world(hierarchy, *hierarchy.find(id)));
    return;
  }
  all_ = hierarchy.subtree(0);
  if (!movers_.empty()) thin_out();
}

const hierarchy::Subtree& HalfView::group(model::NodeId id, const hierarchy::Subtree& known) const {
  if (thinned_.empty()) return known;
  const auto found = thinned_.find(id);
  return found == thinned_.end() ? known : found->second;
}

/// From the deepest up, each group above a mover once.
void HalfView::thin_out() {
  std::map<std::size_t, std::map<model::NodeId, std::vector<model::NodeId>>, std::greater<>>
      by_depth;
  for (const model::NodeId id : movers_) {
    const model::NodeId parent = hierarchy_.find(id)->parent;
    by_depth[depth(hierarchy_, parent)][parent].push_back(id);
  }
  for (auto level = by_depth.begin(); level != by_depth.end(); ++level) {
    for (auto& [group, changed] : level->second) {
      std::sort(changed.begin(), changed.end());
      const hierarchy::Subtree sum = thinned(group, changed);
      if (group == 0) {
        all_ = sum;
        continue;
      }
      thinned_[group] = sum;
      const model::NodeId parent = hierarchy_.find(group)->parent;
      by_depth[level->first - 1][parent].push_back(group);
    }
  }
}

/// `changed`: the group's children that are movers or stand above some.
hierarchy::Subtree HalfView::thinned(model::NodeId group,
                                     const std::vector<model::NodeId>& changed) const {
  const auto before = [&](model::NodeId id) { return part_of_child(hierarchy_, group, id); };
  const auto after = [&](model::NodeId id) {
    const model::Node* node = hierarchy_.find(id);
    if (node == nullptr || node->parent != group || !holds(*node)) return hierarchy::Subtree{};
    const auto found = thinned_.find(id);
    return found == thinned_.end() ? part_of_child(hierarchy_, group, id)
                                   : part_in_parent(*node, found->second);
  };
  hierarchy::Subtree sum =
      group == 0 ? hierarchy::Subtree{} : hierarchy::own_part(*hierarchy_.find(group));
  if (const std::shared_ptr<const hierarchy::WideSum>* wide = hierarchy_.wide.find(group)) {
    include(sum, (*wide)->total_with(changed, {before, after}));
    return sum;
  }
  for (const model::NodeId child : children_of(hierarchy_, group)) include(sum, after(child));
  return sum;
}

}  // namespace sightline::scenegraph::instances
