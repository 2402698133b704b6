// Edits and their checks.
#include "scenegraph/revision/draft.h"

#include <algorithm>
#include <cmath>

namespace sightline::scenegraph::revision {
namespace {

Error error(Code code, std::string reason, std::string message) {
  return {code, std::move(message), std::move(reason)};
}

/// Checks that a matrix is finite. whose() returns the name for the message.
template <class Whose>
Status check_matrix(const model::Affine& matrix, const Whose& whose) {
  if (is_finite(matrix)) return {};
  const double bad = *std::ranges::find_if_not(matrix.m, [](double x) { return std::isfinite(x); });
  return error(Code::kInvalidArgument, "NOT_FINITE",
               "the transform of " + whose() + " holds " +
                   (std::isnan(bad) ? "nan"
                    : bad > 0       ? "inf"
                                    : "-inf") +
                   ", which is not finite");
}

Error too_deep(const std::string& what) {
  return error(Code::kInvalidArgument, "TOO_DEEP",
               what + " would be at least " + std::to_string(model::kMaxDepth + 1) +
                   " nodes deep, the limit is " + std::to_string(model::kMaxDepth));
}

/// Changes a list of children. A child may come and leave several times: the last to come is the
/// last in the list.
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
  if (Status good = model::check_labels(put.labels); !good) return good;
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
  node.labels = put.labels;
  node.set_transform(put.parent_from_local);
  deformations_.forget(id);
  node.patched = false;
  if (put.mesh != node.mesh) {
    node.mesh = put.mesh;
    node.entered = put.mesh == nullptr ? nullptr : std::make_shared<std::atomic<bool>>(false);
  }
  node.mesh_digest = put.mesh_digest;
  node.mobility = put.mobility;
  node.mask = put.mask;
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
    const auto named = [&] { return described(node); };
    if (Status s = check_matrix(set.parent_from_local[i], named); !s) return s;
    node.set_transform(set.parent_from_local[i]);
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

/// Checks that an old node may become a child of this parent: there is no cycle, and it is not
/// deeper than kMaxDepth. Nodes below it, and new nodes, are checked by finish(). A node without
/// children has nothing below it that could be its parent.
Status Draft::check_parent(model::NodeId node, model::NodeId parent) const {
  if (find(node)->children.empty() && !joined_.contains(node) && node != parent) return {};
  int depth = 1;
  for (model::NodeId p = parent; p != 0; p = find(p)->parent) {
    if (p == node) {
      return error(Code::kInvalidArgument, "NODE_CYCLE",
                   described(*find(node)) + " cannot be put under " + described(*find(parent)) +
                       ", which is below it: that would be a cycle");
    }
    if (++depth > model::kMaxDepth) return too_deep(described(*find(node)));
  }
  return {};
}

Status Draft::finish() {
  if (Status deformed = deform(); !deformed) return deformed;
  update_children();
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
  if (!update.finish(cancelled_)) {
    const Status wanted = check_cancelled();
    return wanted ? Status(too_deep("the hierarchy")) : wanted;
  }
  return check_range();
}

/// Checks that coordinates are finite when summed up, as rays find instances by these sums. The
/// error names the node whose transform is too much.
Status Draft::check_range() const {
  if (is_finite(hierarchy_.summary(0).magnitude)) return {};
  model::NodeId group = 0;
  for (bool found = true; found;) {
    found = false;
    for (const model::NodeId child : children_of(hierarchy_, group)) {
      if (is_finite(summary_of_child(hierarchy_, group, child).magnitude)) continue;
      group = child;
      found = !find(child)->children.empty();
      break;
    }
  }
  return error(Code::kInvalidArgument, "NOT_FINITE",
               "the transforms of " + described(*find(group)) +
                   " and of the nodes below it lead beyond 1.8e308 together");
}

std::shared_ptr<const Snapshot> Draft::publish(const MergeState& state) && {
  instances::SceneTrees trees = next_trees(base_, hierarchy_, change_, state);
  return std::make_shared<const Snapshot>(base_.revision() + 1, std::move(hierarchy_),
                                          std::move(trees));
}

}  // namespace sightline::scenegraph::revision
