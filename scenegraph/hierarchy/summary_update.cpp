// From the leaves up: what changed below a group changes the group.
#include "scenegraph/hierarchy/summary_update.h"

#include <algorithm>
#include <utility>

#include "scenegraph/hierarchy/wide_sum.h"

namespace sightline::scenegraph::hierarchy {
namespace {

/// A group of which more than one child in so many has changed is summed up again.
constexpr std::size_t kAdjustBelow = 4;

Subtree own_part(const Hierarchy& in, model::NodeId group) {
  return group == 0 ? Subtree{} : hierarchy::own_part(*in.find(group));
}

}  // namespace

model::Affine world_from_local(const Hierarchy& hierarchy, const model::Node& node) {
  if (node.parent == 0) return node.parent_from_local;
  return compose(world_from_local(hierarchy, *hierarchy.find(node.parent)), node.parent_from_local);
}

const std::vector<model::NodeId>& children_of(const Hierarchy& in, model::NodeId group) {
  return group == 0 ? *in.roots : in.find(group)->children;
}

Subtree part_of_child(const Hierarchy& in, model::NodeId group, model::NodeId child) {
  const model::Node* node = in.find(child);
  if (node == nullptr || node->parent != group) return {};
  return part_in_parent(*node, in.subtree(*node));
}

Subtree Hierarchy::subtree(model::NodeId id) const {
  if (id != 0) return subtree(*find(id));
  const std::shared_ptr<const Subtree>* known = subtrees.find(0);
  return known == nullptr ? Subtree{} : **known;
}

Subtree Hierarchy::subtree(const model::Node& node) const {
  if (node.children.empty()) return own_part(node);
  return group(node.id);
}

SubtreeUpdate::SubtreeUpdate(const Hierarchy& before, Hierarchy& after)
    : before_(before), after_(after) {
  for (int depth = 0; depth <= model::kMaxDepth; ++depth) changes_.emplace_back(&memory_);
}

void SubtreeUpdate::edited(model::NodeId id) {
  const model::Node* node = after_.find(id);
  const model::Node* old = before_.find(id);
  const bool left = old != nullptr && (node == nullptr || node->parent != old->parent);
  if (left && is_parent(old->parent)) changes_at(old->parent)[old->parent].push_back(id);
  if (node != nullptr && !node->children.empty()) {
    changes_at(id).try_emplace(id);  // brought to its parent when it is summed up itself
    return;
  }
  if (old != nullptr && !old->children.empty()) {
    subtrees_.set(id, nullptr);
    if (before_.wide.find(id) != nullptr) wide_.set(id, nullptr);
  }
  if (node != nullptr) changes_at(node->parent)[node->parent].push_back(id);
}

/// Whether the node is there and has children. One that has lost its last was edited too.
bool SubtreeUpdate::is_parent(model::NodeId id) const {
  if (id == 0) return true;
  const model::Node* node = after_.find(id);
  return node != nullptr && !node->children.empty();
}

void SubtreeUpdate::finish() {
  for (std::size_t d = changes_.size(); d-- > 0;) {
    for (const auto& [group, children] : changes_[d]) {
      update(group, children);
      if (group == 0) continue;
      const model::NodeId parent = after_.find(group)->parent;
      changes_[d - 1][parent].push_back(group);
    }
  }
}

/// Nodes of a hierarchy that is being loaded come parent by parent.
std::size_t SubtreeUpdate::depth(model::NodeId id) {
  if (id == last_) return last_depth_;
  std::size_t depth = 0;
  for (model::NodeId at = id; at != 0; at = after_.find(at)->parent) ++depth;
  last_ = id;
  last_depth_ = depth;
  return depth;
}

void SubtreeUpdate::update(model::NodeId group, const Children& changed) {
  Subtree sum;
  const std::vector<model::NodeId>& children = children_of(after_, group);
  if (children.size() > WideSum::kWide) {
    sum = wide_sum_of(group, changed);
  } else {
    if (before_.wide.find(group) != nullptr) wide_.set(group, nullptr);
    if (children.empty()) return subtrees_.set(group, nullptr);  // no roots are left
    if (!adjust(group, changed, sum)) sum = sum_of(group, children);
  }
  subtrees_.set(group, std::make_shared<const Subtree>(sum));
}

Subtree SubtreeUpdate::wide_sum_of(model::NodeId group, const Children& changed) {
  const std::shared_ptr<const WideSum>* known = before_.wide.find(group);
  auto children =
      known == nullptr ? std::make_shared<WideSum>() : std::make_shared<WideSum>(**known);
  std::vector<model::NodeId> ids;
  if (known == nullptr) {
    ids = children_of(after_, group);
  } else {
    ids.assign(changed.begin(), changed.end());
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  children->update(ids, {[&](model::NodeId id) {
                           return known == nullptr ? Subtree{} : part_of_child(before_, group, id);
                         },
                         [&](model::NodeId id) { return part_of_child(after_, group, id); }});
  Subtree sum = own_part(after_, group);
  include(sum, children->total());
  wide_.set(group, std::move(children));
  return sum;
}

/// False where all children must be looked at.
bool SubtreeUpdate::adjust(model::NodeId group, const Children& changed, Subtree& sum) const {
  const std::shared_ptr<const Subtree>* known = before_.subtrees.find(group);
  if (known == nullptr || changed.size() * kAdjustBelow > children_of(after_, group).size())
    return false;
  sum = **known;
  if (!replace(sum, own_part(before_, group), own_part(after_, group))) return false;
  for (const model::NodeId child : changed) {
    if (!replace(sum, part_of_child(before_, group, child), part_of_child(after_, group, child)))
      return false;
  }
  return true;
}

Subtree SubtreeUpdate::sum_of(model::NodeId group,
                              const std::vector<model::NodeId>& children) const {
  Subtree sum;
  include(sum, own_part(after_, group));
  for (const model::NodeId child : children) include(sum, part_of_child(after_, group, child));
  return sum;
}

}  // namespace sightline::scenegraph::hierarchy
