// Edits and their checks.
#include "scenegraph/revision/draft.h"

#include <algorithm>

namespace sightline::scenegraph::revision {
namespace {

Error error(Code code, std::string reason, std::string message) {
  return {code, std::move(message), std::move(reason)};
}

/// `whose`: returns the name for the message.
template <class Whose>
Status check_matrix(const model::Affine& matrix, const Whose& whose) {
  if (inverse(matrix)) return {};
  return error(Code::kInvalidArgument, "SINGULAR_TRANSFORM",
               "the transform of " + whose() +
                   " is not finite, singular, or has a condition number above 1e12");
}

Error too_deep(const std::string& what, int depth) {
  return error(Code::kInvalidArgument, "TOO_DEEP",
               what + " would be at least " + std::to_string(depth) + " nodes deep, the limit is " +
                   std::to_string(model::kMaxDepth));
}

/// Also for children that come and leave several times: the last to come is the last in the list.
template <class Changes>
void change(model::ChildList& children, const Changes& joined, const Changes& left,
            model::NodeId parent) {
  if (const auto found = joined.find(parent); found != joined.end()) children.append(found->second);
  if (const auto found = left.find(parent); found != left.end())
    children.erase_first(found->second);
}

}  // namespace

Status Draft::check_cancelled() const {
  if (cancelled_ == nullptr || !cancelled_->load(std::memory_order_relaxed)) return {};
  return error(Code::kCancelled, "CANCELLED", "cancelled while the updates were applied");
}

Status Draft::apply(const model::Update& update) {
  if (Status wanted = check_cancelled(); !wanted) return wanted;
  if (const auto* u = std::get_if<model::PutNode>(&update)) return put(*u);
  if (const auto* u = std::get_if<model::SetTransforms>(&update)) return set_transforms(*u);
  if (const auto* u = std::get_if<model::PatchVertices>(&update)) return patch(*u);
  return remove(std::get<model::DeleteNode>(update));
}

Status Draft::put(const model::PutNode& put) {
  if (put.name.size() > model::kMaxNodeName) {
    return error(Code::kInvalidArgument, "NAME_TOO_LONG",
                 "a node's name has " + std::to_string(put.name.size()) + " bytes, the limit is " +
                     std::to_string(model::kMaxNodeName));
  }
  const auto named = [&] { return "node \"" + put.name + "\""; };
  if (Status s = check_matrix(put.parent_from_local, named); !s) return s;
  model::NodeId parent = 0;
  if (put.parent != 0) {
    const Result<model::NodeId> found = resolve(put.parent);
    if (!found)
      return error(found.error().code, "PARENT_NOT_FOUND", "parent: " + found.error().message);
    parent = *found;
  }
  model::NodeId id = 0;
  if (put.node < 0 && !aliases_.contains(put.node)) {
    id = next_id_++;
    aliases_[put.node] = id;
    auto fresh = std::make_shared<model::Node>();
    fresh->id = id;
    fresh->parent = parent;
    edited_[id] = std::move(fresh);
    if (Status s = check_parent(id, parent); !s) return s;
    join(id, parent);
  } else {
    const Result<model::NodeId> found = resolve(put.node);
    if (!found) return found.error();
    id = *found;
    if (find(id)->parent != parent) {
      if (Status s = check_parent(id, parent); !s) return s;
      leave(id, find(id)->parent);
      join(id, parent);
    }
  }
  model::Node& node = edit(id);
  node.parent = parent;
  node.name = put.name;
  node.parent_from_local = put.parent_from_local;
  deformations_.forget(id);
  node.patched = false;
  if (put.mesh != node.mesh) {
    node.mesh = put.mesh;
    node.entered = put.mesh == nullptr ? nullptr : std::make_shared<std::atomic<bool>>(false);
  }
  node.mesh_digest = put.mesh_digest;
  node.mobility = put.mobility;
  node.mask = put.mask;
  moved_.insert(id);
  put_nodes_.push_back(id);
  return {};
}

Status Draft::set_transforms(const model::SetTransforms& set) {
  if (set.nodes.size() != set.parent_from_local.size()) {
    return error(Code::kInvalidArgument, "COUNT_MISMATCH",
                 std::to_string(set.nodes.size()) + " nodes but " +
                     std::to_string(set.parent_from_local.size()) + " transforms");
  }
  for (std::size_t i = 0; i < set.nodes.size(); ++i) {
    if (Status wanted = check_cancelled(); !wanted) return wanted;
    const Result<model::NodeId> id = resolve(set.nodes[i]);
    if (!id) return id.error();
    model::Node& node = edit(*id);
    node.parent_from_local = set.parent_from_local[i];
    if (Status s = check_matrix(node.parent_from_local, [&] { return described(node); }); !s)
      return s;
    moved_.insert(*id);
  }
  return {};
}

Status Draft::remove(const model::DeleteNode& removal) {
  const Result<model::NodeId> found = resolve(removal.node);
  if (!found) return found.error();
  const model::Node& top = *find(*found);
  const std::vector<model::NodeId> children = children_now(top);
  if (!children.empty() && !removal.subtree) {
    return error(Code::kFailedPrecondition, "NODE_HAS_CHILDREN",
                 described(top) + " has " + std::to_string(children.size()) +
                     " children; set subtree to delete them too");
  }
  leave(top.id, top.parent);
  std::vector<model::NodeId> doomed{top.id};
  while (!doomed.empty()) {
    if (Status wanted = check_cancelled(); !wanted) return wanted;
    const model::NodeId id = doomed.back();
    doomed.pop_back();
    const std::vector<model::NodeId> below = children_now(*find(id));
    doomed.insert(doomed.end(), below.begin(), below.end());
    joined_.erase(id);
    left_.erase(id);
    edited_[id] = nullptr;
    moved_.erase(id);
    deformations_.forget(id);
  }
  return {};
}

Status Draft::patch(const model::PatchVertices& patch) {
  std::vector<const model::Node*> nodes;
  for (const model::NodeRef ref : patch.nodes) {
    const Result<model::NodeId> id = resolve(ref);
    if (!id) return id.error();
    nodes.push_back(find(*id));
  }
  return deformations_.patch(nodes, patch.first, patch.positions);
}

Status Draft::deform() {
  const auto meshes = deformations_.make();
  if (!meshes) return meshes.error();
  for (const auto& [id, mesh] : *meshes) {
    model::Node& node = edit(id);
    node.mesh = mesh;
    node.patched = true;
    node.entered = std::make_shared<std::atomic<bool>>(false);
    moved_.insert(id);
  }
  return {};
}

Result<model::NodeId> Draft::resolve(model::NodeRef ref) const {
  if (ref < 0) {
    const auto found = aliases_.find(ref);
    if (found != aliases_.end() && find(found->second) != nullptr) return found->second;
    return error(Code::kNotFound, "NODE_NOT_FOUND",
                 "alias " + std::to_string(ref) + " names no node put earlier in this batch");
  }
  const auto id = static_cast<model::NodeId>(ref);
  if (id != 0 && find(id) != nullptr) return id;
  return error(Code::kNotFound, "NODE_NOT_FOUND", "there is no node " + std::to_string(ref));
}

const model::Node* Draft::find(model::NodeId id) const {
  const auto found = edited_.find(id);
  return found != edited_.end() ? found->second.get() : base_.find(id);
}

model::Node& Draft::edit(model::NodeId id) {
  std::shared_ptr<model::Node>& node = edited_[id];
  if (node == nullptr) node = std::make_shared<model::Node>(*base_.find(id));
  return *node;
}

void Draft::join(model::NodeId id, model::NodeId parent) { joined_[parent].push_back(id); }

void Draft::leave(model::NodeId id, model::NodeId parent) { left_[parent].push_back(id); }

std::vector<model::NodeId> Draft::children_now(const model::Node& node) const {
  model::ChildList children = node.children;
  change(children, joined_, left_, node.id);
  return {children.begin(), children.end()};
}

void Draft::update_children() {
  const auto update = [this](model::NodeId parent) {
    if (parent != 0) return change(edit(parent).children, joined_, left_, parent);
    auto roots = std::make_shared<model::ChildList>(base_.roots());
    change(*roots, joined_, left_, parent);
    hierarchy_.roots = std::move(roots);
  };
  for (const auto& [parent, children] : joined_) update(parent);
  for (const auto& [parent, children] : left_) {
    if (!joined_.contains(parent)) update(parent);
  }
}

/// The node may be a child of this parent: no cycle, and not deeper than kMaxDepth. What hangs
/// below it is checked by finish().
Status Draft::check_parent(model::NodeId node, model::NodeId parent) const {
  int depth = 1;
  for (model::NodeId p = parent; p != 0; p = find(p)->parent) {
    if (p == node) {
      return error(Code::kInvalidArgument, "NODE_CYCLE",
                   described(*find(node)) + " cannot be put under " + described(*find(parent)) +
                       ", which is below it: that would be a cycle");
    }
    if (++depth > model::kMaxDepth) return too_deep(described(*find(node)), depth);
  }
  return {};
}

/// Of the nodes that have another parent than before. Thus no node is deeper than kMaxDepthHere.
Status Draft::check_depths() const {
  for (const auto& [id, node] : edited_) {
    if (Status wanted = check_cancelled(); !wanted) return wanted;
    const model::Node* old = base_.find(id);
    if (node == nullptr || (old != nullptr && old->parent == node->parent)) continue;
    if (Status s = check_parent(id, node->parent); !s) return s;
  }
  return {};
}

model::Affine Draft::world_from_local(const model::Node& node) const {
  return node.parent == 0 ? node.parent_from_local
                          : compose(world_from_local(*find(node.parent)), node.parent_from_local);
}

Status Draft::finish() {
  if (Status deformed = deform(); !deformed) return deformed;
  update_children();
  if (Status shallow = check_depths(); !shallow) return shallow;
  change_ = classify_changes(base_, edited_, cancelled_);
  if (Status wanted = check_cancelled(); !wanted) return wanted;
  hierarchy_.changed_at = change_.changed_at;
  {
    hierarchy::NodeMap::Edit nodes(hierarchy_.nodes);
    for (const auto& [id, node] : edited_) {
      if (Status wanted = check_cancelled(); !wanted) return wanted;
      nodes.set(id, node);
    }
  }
  hierarchy::SummaryUpdate update(base_.hierarchy(), hierarchy_);
  for (const auto& [id, node] : edited_) {
    if (Status wanted = check_cancelled(); !wanted) return wanted;
    update.edited(id);
  }
  if (!update.finish(cancelled_)) return check_cancelled();
  const auto deepest = static_cast<int>(hierarchy_.summary(0).height) - 1;
  if (deepest > model::kMaxDepth) return too_deep("the hierarchy", deepest);
  return check_transforms();
}

Status Draft::check_transforms() const {
  for (const model::NodeId id : moved_) {
    const model::Node& node = *find(id);
    if (Status s = check_below(node, world_from_local(node)); !s) return s;
  }
  return {};
}

Status Draft::check_below(const model::Node& node, const model::Affine& world) const {
  if (Status wanted = check_cancelled(); !wanted) return wanted;
  if (node.mesh != nullptr) {
    const auto with_those_above = [&] { return described(node) + ", with those above it,"; };
    if (Status s = check_matrix(world, with_those_above); !s) return s;
  }
  if (node.children.empty() || surely_invertible(world, hierarchy_.group(node.id))) return {};
  for (const model::NodeId child : node.children) {
    // A child that moved too is checked on its own.
    if (moved_.contains(child)) continue;
    if (Status s = check_below(*find(child), compose(world, find(child)->parent_from_local)); !s)
      return s;
  }
  return {};
}

std::shared_ptr<const Snapshot> Draft::publish(const MergeState& state) && {
  instances::SceneTrees trees = next_trees(base_, hierarchy_, change_, state);
  return std::make_shared<const Snapshot>(base_.revision() + 1, std::move(hierarchy_),
                                          std::move(trees));
}

}  // namespace sightline::scenegraph::revision
