// Sums over the static side, from the dynamic roots up, and over the dynamic side.
#include "scenegraph/instances/mobility_view.h"

#include <algorithm>
#include <map>

#include "scenegraph/hierarchy/summary_tree.h"

namespace sightline::scenegraph::instances {
namespace {

std::size_t depth(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  std::size_t depth = 0;
  for (; id != 0; id = hierarchy.find(id)->parent) ++depth;
  return depth;
}

/// What the node adds to the scene's summary, in world space.
hierarchy::NodeSummary summary_in_world(const hierarchy::Hierarchy& hierarchy,
                                        const model::Node& node) {
  hierarchy::NodeSummary part = summary_in_parent(node, hierarchy.summary(node));
  for (model::NodeId above = node.parent; above != 0; above = hierarchy.find(above)->parent)
    part = transformed(hierarchy.find(above)->parent_from_local, part);
  return part;
}

}  // namespace

bool is_dynamic(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  if (hierarchy.dynamic_roots.size() == 0) return false;
  return any_upward(hierarchy, id, [&](model::NodeId above) {
    return hierarchy.dynamic_roots.find(above) != nullptr;
  });
}

std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy) {
  std::vector<model::NodeId> dynamic_roots;
  dynamic_roots.reserve(hierarchy.dynamic_roots.size());
  hierarchy.dynamic_roots.for_each([&](model::NodeId id, bool) {
    if (!is_dynamic(hierarchy, hierarchy.find(id)->parent)) dynamic_roots.push_back(id);
  });
  return dynamic_roots;
}

MobilityView::MobilityView(MobilitySide side, const hierarchy::Hierarchy& hierarchy)
    : hierarchy_(hierarchy),
      side_(side),
      dynamic_roots_(std::span<const model::NodeId>(topmost_dynamic_roots(hierarchy))) {
  if (side == MobilitySide::kDynamic) {
    for (const model::NodeId id : dynamic_roots_)
      add(all_, summary_in_world(hierarchy, *hierarchy.find(id)));
    return;
  }
  all_ = hierarchy.summary(0);
  if (!dynamic_roots_.empty()) leave_out_dynamic();
}

const hierarchy::NodeSummary& MobilityView::group(model::NodeId id,
                                                  const hierarchy::NodeSummary& known) const {
  if (without_dynamic_.empty()) return known;
  const auto found = without_dynamic_.find(id);
  return found == without_dynamic_.end() ? known : found->second;
}

/// From the deepest group up, each group above a dynamic root once.
void MobilityView::leave_out_dynamic() {
  std::map<std::size_t, std::map<model::NodeId, std::vector<model::NodeId>>, std::greater<>>
      by_depth;
  for (const model::NodeId id : dynamic_roots_) {
    const model::NodeId parent = hierarchy_.find(id)->parent;
    by_depth[depth(hierarchy_, parent)][parent].push_back(id);
  }
  for (auto level = by_depth.begin(); level != by_depth.end(); ++level) {
    for (auto& [group, changed] : level->second) {
      std::sort(changed.begin(), changed.end());
      const hierarchy::NodeSummary sum = without_dynamic(group, changed);
      if (group == 0) {
        all_ = sum;
        continue;
      }
      without_dynamic_[group] = sum;
      const model::NodeId parent = hierarchy_.find(group)->parent;
      by_depth[level->first - 1][parent].push_back(group);
    }
  }
}

/// `changed`: the group's children that are dynamic roots or above some.
hierarchy::NodeSummary MobilityView::without_dynamic(
    model::NodeId group, const std::vector<model::NodeId>& changed) const {
  const auto before = [&](model::NodeId id) { return summary_of_child(hierarchy_, group, id); };
  const auto after = [&](model::NodeId id) {
    const model::Node* node = hierarchy_.find(id);
    if (node == nullptr || node->parent != group || !holds(*node)) return hierarchy::NodeSummary{};
    const auto found = without_dynamic_.find(id);
    return found == without_dynamic_.end() ? summary_of_child(hierarchy_, group, id)
                                           : summary_in_parent(*node, found->second);
  };
  hierarchy::NodeSummary sum =
      group == 0 ? hierarchy::NodeSummary{} : hierarchy::own_summary(*hierarchy_.find(group));
  if (const std::shared_ptr<const hierarchy::SummaryTree>* tree =
          hierarchy_.summary_trees.find(group)) {
    add(sum, (*tree)->total_with(changed, {before, after}));
    return sum;
  }
  for (const model::NodeId child : children_of(hierarchy_, group)) add(sum, after(child));
  return sum;
}

}  // namespace sightline::scenegraph::instances
