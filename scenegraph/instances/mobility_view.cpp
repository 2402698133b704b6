// Sums over the static side, from the dynamic roots up; the roots of a dynamic side.
#include "scenegraph/instances/mobility_view.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "scenegraph/hierarchy/summary_tree.h"
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::instances {
namespace {

std::size_t depth(const hierarchy::Hierarchy& hierarchy, model::NodeId id) {
  std::size_t depth = 0;
  for (; id != 0; id = hierarchy.find(id)->parent) ++depth;
  return depth;
}

/// A node that may be a root of a dynamic side, and what older trees know of it.
struct Candidate {
  model::NodeId id = 0;
  const model::Node* node = nullptr;
  const Instance* known = nullptr;
};

/// Appends the roots of an older tree. Its instances are those of this one if their nodes are the
/// same, and the trees' centers.
void add_part(const SceneTree& part, const hierarchy::Hierarchy& hierarchy,
              const accel::geometry::Vec3d& center, std::vector<Candidate>& candidates) {
  const Instances& instances = part.instances();
  const bool same_center = instances.center() == center;
  instances.for_each_root([&](model::NodeId id, const model::Node* node, const Instance* known) {
    const bool same = known != nullptr && same_center && hierarchy.find(id) == node;
    candidates.push_back({id, nullptr, same ? known : nullptr});
  });
}

void add_changed(const std::optional<model::ChildList>& some, const hierarchy::Hierarchy& hierarchy,
                 std::vector<Candidate>& candidates) {
  if (some) {
    for (const model::NodeId id : *some) candidates.push_back({id});
  } else {
    hierarchy.changed_at.for_each(
        [&](model::NodeId id, std::uint64_t) { candidates.push_back({id}); });
  }
}

/// Of these nodes, those that are there, have changed after this revision, and have no such node
/// above them; ascending, each once.
void keep_topmost(const hierarchy::Hierarchy& hierarchy, std::uint64_t after,
                  std::vector<Candidate>& candidates) {
  const auto changed = [&](model::NodeId id) {
    const std::uint64_t* at = hierarchy.changed_at.find(id);
    return at != nullptr && *at > after;
  };
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.id, a.known == nullptr) < std::pair(b.id, b.known == nullptr);
  });
  const auto same = [](const Candidate& a, const Candidate& b) { return a.id == b.id; };
  candidates.erase(std::unique(candidates.begin(), candidates.end(), same), candidates.end());
  std::erase_if(candidates, [&](Candidate& candidate) {
    candidate.node = hierarchy.find(candidate.id);
    return candidate.node == nullptr || !changed(candidate.id) ||
           any_upward(hierarchy, candidate.node->parent, changed);
  });
}

/// The origin for an empty or infinite box.
accel::geometry::Vec3d middle(const model::DoubleBox& box) {
  const accel::geometry::Vec3d m = (box.lo + box.hi) * 0.5;
  return accel::geometry::is_finite(m) ? m : accel::geometry::Vec3d{};
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

std::vector<model::NodeId> topmost_dynamic_roots(const hierarchy::Hierarchy& hierarchy) {
  std::vector<Candidate> candidates;
  add_changed(std::nullopt, hierarchy, candidates);
  keep_topmost(hierarchy, 0, candidates);
  std::vector<model::NodeId> roots;
  for (const Candidate& candidate : candidates) roots.push_back(candidate.id);
  return roots;
}

MobilityView::MobilityView(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved)
    : hierarchy_(hierarchy), is_static_(moved == nullptr) {
  if (moved != nullptr) {
    find_moved(*moved);
    return;
  }
  all_ = hierarchy.summary(0);
  const std::vector<model::NodeId> roots = topmost_dynamic_roots(hierarchy);
  if (!roots.empty()) leave_out_dynamic(roots);
  center_ = middle(all_.box);
}

void MobilityView::find_moved(const MovedNodes& moved) {
  center_ = moved.static_tree->instances().center();
  std::vector<Candidate> roots;
  for (const auto& part : moved.parts) add_part(*part, hierarchy_, center_, roots);
  add_changed(moved.candidates, hierarchy_, roots);
  keep_topmost(hierarchy_, moved.after, roots);
  moved_.reserve(roots.size());
  for (const auto& [id, node, known] : roots) {
    const std::shared_ptr<const hierarchy::NodeSummary>* below =
        node->children.empty() ? nullptr : hierarchy_.summaries.find(id);
    if (below != nullptr && is_group(*node, **below)) {
      moved_.push_back({node, below->get()});
      all_.instances += (*below)->instances;
      all_.entry_cost += (*below)->entry_cost;
    } else if (hierarchy::is_instance(*node)) {
      moved_.push_back({node, nullptr, known});
      ++all_.instances;
      all_.entry_cost += hierarchy::entry_cost(*node->mesh);
    } else {
      without_instances_.push_back(id);
    }
  }
}

const hierarchy::NodeSummary& MobilityView::group(model::NodeId id,
                                                  const hierarchy::NodeSummary& known) const {
  if (without_dynamic_.empty()) return known;
  const auto found = without_dynamic_.find(id);
  return found == without_dynamic_.end() ? known : found->second;
}

/// From the deepest group up, each group above a dynamic root once.
void MobilityView::leave_out_dynamic(const std::vector<model::NodeId>& roots) {
  std::map<std::size_t, std::map<model::NodeId, std::vector<model::NodeId>>, std::greater<>>
      by_depth;
  for (const model::NodeId id : roots) {
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
