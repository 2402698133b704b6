// Sums over the static side, from the dynamic roots up, and over the dynamic side.
#include "scenegraph/instances/mobility_view.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

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

/// Of these nodes, those that are there, have changed after this revision, and have no such node
/// above them; ascending.
std::vector<model::NodeId> topmost_changed_after(const hierarchy::Hierarchy& hierarchy,
                                                 std::uint64_t after,
                                                 std::vector<model::NodeId> candidates) {
  const auto changed = [&](model::NodeId id) {
    const std::uint64_t* at = hierarchy.changed_at.find(id);
    return at != nullptr && *at > after;
  };
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  std::erase_if(candidates, [&](model::NodeId id) {
    if (!changed(id)) return true;
    const model::Node* node = hierarchy.find(id);
    return node == nullptr || any_upward(hierarchy, node->parent, changed);
  });
  return candidates;
}

}  // namespace

std::uint64_t last_change(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  std::uint64_t last = 0;
  if (hierarchy.changed_at.size() == 0) return last;
  for (; id != 0; id = hierarchy.find(id)->parent) {
    if (const std::uint64_t* at = hierarchy.changed_at.find(id)) last = std::max(last, *at);
  }
  return last;
}

std::vector<model::NodeId> candidates_of(const MovedNodes& moved,
                                         const hierarchy::Hierarchy& hierarchy) {
  if (moved.candidates) return {moved.candidates->begin(), moved.candidates->end()};
  std::vector<model::NodeId> changed;
  changed.reserve(hierarchy.changed_at.size());
  hierarchy.changed_at.for_each([&](model::NodeId id, std::uint64_t) { changed.push_back(id); });
  return changed;
}

std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy) {
  return topmost_changed_after(hierarchy, 0, candidates_of({}, hierarchy));
}

MobilityView::MobilityView(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved)
    : hierarchy_(hierarchy),
      is_static_(moved == nullptr),
      dynamic_roots_(std::span<const model::NodeId>(
          moved == nullptr
              ? topmost_dynamic_roots(hierarchy)
              : topmost_changed_after(hierarchy, moved->after, candidates_of(*moved, hierarchy)))) {
  if (!is_static_) {
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
  hierarchy::NodeSummary adjusted = hierarchy_.summary(group);
  const bool exact = std::all_of(changed.begin(), changed.end(), [&](model::NodeId id) {
    return try_replace(adjusted, before(id), after(id));
  });
  if (exact) return adjusted;
  for (const model::NodeId child : children_of(hierarchy_, group)) add(sum, after(child));
  return sum;
}

}  // namespace sightline::scenegraph::instances
