// Sums up groups from the deepest to the root.
#include "scenegraph/hierarchy/summary_update.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "scenegraph/hierarchy/summary_tree.h"

namespace sightline::scenegraph::hierarchy {
namespace {

/// A group is summed up again if more than one in this many children has changed.
constexpr std::size_t kAdjustBelow = 4;

NodeSummary own_summary(const Hierarchy& in, model::NodeId group) {
  return group == 0 ? NodeSummary{} : hierarchy::own_summary(*in.find(group));
}

}  // namespace

model::Affine world_from_local(const Hierarchy& hierarchy, const model::Node& node) {
  std::vector<const model::Node*> path{&node};  // no recursion: it may be long
  while (path.back()->parent != 0) path.push_back(hierarchy.find(path.back()->parent));
  model::Affine world = path.back()->parent_from_local;
  for (std::size_t i = path.size() - 1; i-- > 0;)
    world = compose(world, path[i]->parent_from_local);
  return world;
}

const model::ChildList& children_of(const Hierarchy& in, model::NodeId group) {
  return group == 0 ? *in.roots : in.find(group)->children;
}

NodeSummary summary_of_child(const Hierarchy& in, model::NodeId group, model::NodeId child) {
  const model::Node* node = in.find(child);
  if (node == nullptr || node->parent != group) return {};
  return summary_in_parent(*node, in.summary(*node));
}

NodeSummary Hierarchy::summary(model::NodeId id) const {
  if (id != 0) return summary(*find(id));
  const std::shared_ptr<const NodeSummary>* known = summaries.find(0);
  return known == nullptr ? NodeSummary{} : **known;
}

NodeSummary Hierarchy::summary(const model::Node& node) const {
  if (node.children.empty()) return own_summary(node);
  return group(node.id);
}

SummaryUpdate::SummaryUpdate(const Hierarchy& before, Hierarchy& after)
    : before_(before), after_(after) {}

void SummaryUpdate::edited(model::NodeId id) {
  const model::Node* node = after_.find(id);
  const model::Node* old = before_.find(id);
  const bool left = old != nullptr && (node == nullptr || node->parent != old->parent);
  if (left && is_parent(old->parent)) changed_[old->parent].push_back(id);
  if (node != nullptr && !node->children.empty()) {
    (void)changed_[id];  // once summed up, it is a changed child of its parent
    return;
  }
  if (old != nullptr && !old->children.empty()) {
    summaries_.set(id, nullptr);
    if (before_.summary_trees.find(id) != nullptr) summary_trees_.set(id, nullptr);
  }
  if (node != nullptr) changed_[node->parent].push_back(id);
}

/// Whether the node is there and has children. A node that has lost its last child was edited too.
bool SummaryUpdate::is_parent(model::NodeId id) const {
  if (id == 0) return true;
  const model::Node* node = after_.find(id);
  return node != nullptr && !node->children.empty();
}

bool SummaryUpdate::finish(const std::atomic<bool>* cancelled) {
  return changed_.visit_upward([&](model::NodeId group, const Children& children) {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) return false;
    const std::uint32_t height = update(group, children);
    return group == 0 || height <= static_cast<std::uint32_t>(model::kMaxDepth);
  });
}

std::uint32_t SummaryUpdate::update(model::NodeId group, const Children& changed) {
  NodeSummary sum;
  const model::ChildList& children = children_of(after_, group);
  if (children.size() > SummaryTree::kWide) {
    sum = tree_sum(group, changed);
  } else {
    if (before_.summary_trees.find(group) != nullptr) summary_trees_.set(group, nullptr);
    if (children.empty()) {  // no roots are left
      summaries_.set(group, nullptr);
      return 0;
    }
    if (!adjust(group, changed, sum)) sum = sum_of(group, children);
  }
  summaries_.set(group, std::make_shared<const NodeSummary>(sum));
  return sum.height;
}

NodeSummary SummaryUpdate::tree_sum(model::NodeId group, const Children& changed) {
  const std::shared_ptr<const SummaryTree>* known = before_.summary_trees.find(group);
  auto children =
      known == nullptr ? std::make_shared<SummaryTree>() : std::make_shared<SummaryTree>(**known);
  std::vector<model::NodeId> ids;
  if (known == nullptr) {
    const model::ChildList& children_now = children_of(after_, group);
    ids.assign(children_now.begin(), children_now.end());
  } else {
    ids.assign(changed.begin(), changed.end());
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  children->update(ids, {[&](model::NodeId id) {
                           return known == nullptr ? NodeSummary{}
                                                   : summary_of_child(before_, group, id);
                         },
                         [&](model::NodeId id) { return summary_of_child(after_, group, id); }});
  NodeSummary sum = own_summary(after_, group);
  add(sum, children->total());
  summary_trees_.set(group, std::move(children));
  return sum;
}

/// Changes the group's former sum by the changed children; false if all children are needed.
bool SummaryUpdate::adjust(model::NodeId group, const Children& changed, NodeSummary& sum) const {
  const std::shared_ptr<const NodeSummary>* known = before_.summaries.find(group);
  if (known == nullptr || changed.size() * kAdjustBelow > children_of(after_, group).size())
    return false;
  sum = **known;
  if (!try_replace(sum, own_summary(before_, group), own_summary(after_, group))) return false;
  for (const model::NodeId child : changed) {
    if (!try_replace(sum, summary_of_child(before_, group, child),
                     summary_of_child(after_, group, child)))
      return false;
  }
  return true;
}

NodeSummary SummaryUpdate::sum_of(model::NodeId group, const model::ChildList& children) const {
  NodeSummary sum;
  add(sum, own_summary(after_, group));
  for (const model::NodeId child : children) add(sum, summary_of_child(after_, group, child));
  return sum;
}

}  // namespace sightline::scenegraph::hierarchy
