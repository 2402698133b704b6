// Sums up the static side, from the dynamic roots up; finds the roots of a dynamic side.
#include "scenegraph/instances/mobility_view.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "scenegraph/hierarchy/changed_groups.h"
#include "scenegraph/hierarchy/summary_tree.h"
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::instances {
namespace {

/// A node that may be a root of a dynamic side, and what an older tree has of it.
struct Candidate {
  model::NodeId id = 0;
  const model::Node* node = nullptr;  // at first the older tree's
  const Instance* known = nullptr;
  bool is_hidden = false;  // it is flat, or a node above it is
};

/// Appends the roots of an older tree. Its instances are used again if the centers are the same, as
/// then their boxes are.
void add_part(const SceneTree& part, const accel::geometry::Vec3d& center,
              std::vector<Candidate>& candidates) {
  const Instances& instances = part.instances();
  const bool same_center = instances.center() == center;
  instances.for_each_root([&](model::NodeId id, const model::Node* node, const Instance* instance) {
    candidates.push_back({id, node, same_center ? instance : nullptr});
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

/// Gives the candidates their nodes in this hierarchy. An older tree's instance is used again only
/// if the node is the same object, as a change makes another. Lookups of many nodes overlap.
void find_nodes(const hierarchy::Hierarchy& hierarchy, std::span<Candidate> candidates) {
  constexpr std::size_t kLookups = 32;
  std::array<model::NodeId, kLookups> ids;
  std::array<const std::shared_ptr<const model::Node>*, kLookups> nodes;
  while (!candidates.empty()) {
    const auto part = candidates.first(std::min(candidates.size(), kLookups));
    std::ranges::transform(part, ids.begin(), &Candidate::id);
    hierarchy.nodes.find_all(std::span(ids).first(part.size()),
                             std::span(nodes).first(part.size()));
    for (std::size_t i = 0; i < part.size(); ++i) {
      const model::Node* node = nodes[i] == nullptr ? nullptr : nodes[i]->get();
      if (part[i].node != node) part[i].known = nullptr;
      part[i].node = node;
      if (part[i].known == nullptr) __builtin_prefetch(node);
    }
    candidates = candidates.subspan(part.size());
  }
}

/// Whether nodes, or those above them, have changed after a revision or are flat.
class ChangedAfter {
 public:
  struct Above {
    bool is_changed = false;
    bool is_flat = false;  // only if nothing is changed
  };

  ChangedAfter(const hierarchy::Hierarchy& hierarchy, std::uint64_t after)
      : hierarchy_(hierarchy), after_(after) {}

  bool at(model::NodeId id) const {
    const std::uint64_t* at = hierarchy_.changed_at.find(id);
    return at != nullptr && *at > after_;
  }
  /// The state of the node and those above it. Remembers the last answer, for siblings.
  const Above& at_or_above(model::NodeId id) {
    if (id == last_) return above_;
    last_ = id;
    above_ = {};
    while (id != 0 && !above_.is_changed) {
      const model::Node& node = *hierarchy_.find(id);
      above_.is_changed = at(id);
      above_.is_flat = above_.is_flat || node.is_flat;
      id = node.parent;
    }
    return above_;
  }

 private:
  const hierarchy::Hierarchy& hierarchy_;
  const std::uint64_t after_;
  model::NodeId last_ = 0;
  Above above_;
};

/// Keeps the candidates that are there, have changed after this revision, and have no such node
/// above them; ascending, each once.
void keep_topmost(const hierarchy::Hierarchy& hierarchy, std::uint64_t after,
                  std::vector<Candidate>& candidates) {
  std::ranges::sort(candidates, {}, &Candidate::id);
  find_nodes(hierarchy, candidates);
  ChangedAfter changed(hierarchy, after);
  std::size_t kept = 0;
  for (const Candidate& candidate : candidates) {
    const model::Node* node = candidate.node;
    const Instance* known = candidate.known;
    if (kept > 0 && candidates[kept - 1].id == candidate.id) {
      if (known != nullptr) candidates[kept - 1].known = known;
    } else if (node != nullptr && (known != nullptr || changed.at(candidate.id))) {
      const ChangedAfter::Above above =
          changed.at_or_above(known != nullptr ? known->parent : node->parent);
      if (above.is_changed) continue;
      candidates[kept] = candidate;
      // A node whose instance an older tree has is not flat.
      candidates[kept++].is_hidden = above.is_flat || (known == nullptr && node->is_flat);
    }
  }
  candidates.resize(kept);
}

/// The middle of a box; the origin if it is empty or infinite.
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
  roots.reserve(candidates.size());
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
  for (const auto& part : moved.parts) add_part(*part, center_, roots);
  add_changed(moved.candidates, hierarchy_, roots);
  keep_topmost(hierarchy_, moved.after, roots);
  moved_.reserve(roots.size());
  for (const auto& [id, node, known, is_hidden] : roots) {
    if (is_hidden) {
      without_instances_.push_back(id);
      continue;
    }
    const hierarchy::NodeSummary* below =
        known != nullptr || node->children.empty() ? nullptr : &hierarchy_.group(id);
    if (below != nullptr && is_group(*node, *below)) {
      moved_.push_back({.node = node, .group = below});
      all_.instances += below->instances;
      all_.entry_cost += below->entry_cost;
    } else if (known != nullptr || hierarchy::is_instance(*node)) {
      moved_.push_back({.node = node, .is_leaf = below == nullptr, .known = known});
      ++all_.instances;
      all_.entry_cost += hierarchy::entry_cost(known != nullptr ? *known->mesh : *node->mesh);
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

/// Sums up each group above a dynamic root once, without the dynamic nodes.
void MobilityView::leave_out_dynamic(const std::vector<model::NodeId>& roots) {
  hierarchy::ChangedGroups above(hierarchy_.nodes);
  for (const model::NodeId id : roots) above[hierarchy_.find(id)->parent].push_back(id);
  above.visit_upward([this](model::NodeId group, const hierarchy::ChangedGroups::Children& some) {
    std::vector<model::NodeId> changed(some.begin(), some.end());
    std::sort(changed.begin(), changed.end());
    (group == 0 ? all_ : without_dynamic_[group]) = without_dynamic(group, changed);
    return true;
  });
}

/// The group's summary without the dynamic nodes. `changed` are its children that are dynamic roots
/// or above some.
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
