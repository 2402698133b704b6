// Makes a hierarchy from nodes that were written down.
#include "scenegraph/revision/restore.h"

#include <atomic>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>

#include "scenegraph/revision/mobility.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {
namespace {

Error corrupt(const std::string& message) {
  return {Code::kDataLoss, "the stored nodes are corrupt: " + message, "CORRUPT_NODES"};
}

class Restorer {
 public:
  explicit Restorer(model::NodeId next_id) : next_id_(next_id) {}

  Status add(model::Node node) {
    const model::NodeId id = node.id;
    if (id == 0 || id >= next_id_) return corrupt("there cannot be " + described(node));
    if (node.parent != 0 && !nodes_.contains(node.parent))
      return corrupt(described(node) + " comes before its parent");
    const int depth = node.parent == 0 ? 1 : depths_.at(node.parent) + 1;
    if (depth > model::kMaxDepth) return corrupt(described(node) + " is too deep");
    if (const Status good = model::check_labels(node.labels); !good)
      return corrupt(described(node) + ": " + good.error().message);
    node.set_transform(node.parent_from_local);
    node.children = {};
    node.entered = node.mesh == nullptr ? nullptr : std::make_shared<std::atomic<bool>>(false);
    children_[node.parent].push_back(id);
    depths_.emplace(id, depth);
    if (!nodes_.emplace(id, std::make_shared<model::Node>(std::move(node))).second)
      return corrupt("node " + std::to_string(id) + " comes twice");
    return {};
  }

  hierarchy::Hierarchy finish() {
    hierarchy::Hierarchy hierarchy;
    for (const auto& [parent, children] : children_) {
      if (parent == 0) {
        hierarchy.roots = std::make_shared<const model::ChildList>(std::span(children));
      } else {
        nodes_.at(parent)->children = model::ChildList(std::span(children));
      }
    }
    const Snapshot empty(0, {});
    hierarchy.changed_at = classify_changes(empty, nodes_).changed_at;
    {
      hierarchy::NodeMap::Edit edit(hierarchy.nodes);
      for (const auto& [id, node] : nodes_) edit.set(id, node);
    }
    hierarchy::SummaryUpdate update(empty.hierarchy(), hierarchy);
    for (const auto& [id, node] : nodes_) update.edited(id);
    update.finish();
    return hierarchy;
  }

 private:
  const model::NodeId next_id_;
  EditedNodes nodes_;
  std::unordered_map<model::NodeId, int> depths_;
  std::unordered_map<model::NodeId, std::vector<model::NodeId>> children_;
};

}  // namespace

Result<hierarchy::Hierarchy> restore_hierarchy(std::vector<model::Node> nodes,
                                               model::NodeId next_id) {
  Restorer restorer(next_id);
  for (model::Node& node : nodes) {
    if (const Status added = restorer.add(std::move(node)); !added) return added.error();
  }
  return restorer.finish();
}

}  // namespace sightline::scenegraph::revision
