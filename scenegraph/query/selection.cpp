// Looks up the hierarchy for the root, the excluded nodes and labels.
#include "scenegraph/query/selection.h"

#include <algorithm>
#include <string>
#include <utility>

namespace sightline::scenegraph::query {

Status check_nodes(const revision::Snapshot& snapshot, std::span<const model::NodeId> ids,
                   const char* role) {
  for (const model::NodeId id : ids) {
    if (snapshot.find(id) != nullptr) continue;
    return Error{Code::kNotFound,
                 std::string(role) + " node " + std::to_string(id) + " is not in revision " +
                     std::to_string(snapshot.revision()),
                 "NODE_NOT_FOUND"};
  }
  return {};
}

Result<Selection> Selection::make(std::shared_ptr<const revision::Snapshot> snapshot,
                                  model::NodeId root, std::span<const model::NodeId> excluded,
                                  LabelFilter labels, Shard shard) {
  const std::span<const model::NodeId> roots(&root, root != 0 ? 1 : 0);
  if (const Status known = check_nodes(*snapshot, roots, "root"); !known) return known.error();
  if (const Status known = check_nodes(*snapshot, excluded, "excluded"); !known)
    return known.error();
  std::vector<model::NodeId> sorted(excluded.begin(), excluded.end());
  std::sort(sorted.begin(), sorted.end());
  return Selection(std::move(snapshot), root, std::move(sorted), std::move(labels),
                   std::move(shard));
}

Selection::Selection(std::shared_ptr<const revision::Snapshot> snapshot, model::NodeId root,
                     std::vector<model::NodeId> excluded, LabelFilter labels, Shard shard)
    : snapshot_(std::move(snapshot)),
      root_(root),
      excluded_(std::move(excluded)),
      labels_(*snapshot_, std::move(labels)),
      shard_(std::move(shard)),
      trees_(snapshot_->trees()),
      selected_(trees_.size()) {}

bool Selection::decide(std::size_t index) const {
  const hierarchy::Hierarchy& hierarchy = snapshot_->hierarchy();
  const model::NodeId node = trees_[index].node;
  const auto is_excluded = [&](model::NodeId id) {
    return std::binary_search(excluded_.begin(), excluded_.end(), id);
  };
  const auto is_root = [&](model::NodeId id) { return id == root_; };
  return shard_.has(node) && (excluded_.empty() || !any_upward(hierarchy, node, is_excluded)) &&
         (root_ == 0 || any_upward(hierarchy, node, is_root)) && labels_.sees(node);
}

}  // namespace sightline::scenegraph::query
