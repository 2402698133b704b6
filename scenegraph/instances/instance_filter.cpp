// Looks up the hierarchy for removed nodes.
#include "scenegraph/instances/instance_filter.h"

#include <utility>

#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::instances {

RemovedFilter::RemovedFilter(std::shared_ptr<const SceneTree> tree, NodeSet nodes)
    : tree_(std::move(tree)), nodes_(std::move(nodes)), removed_(tree_->instances().size()) {}

bool RemovedFilter::decide(std::size_t index) const {
  const hierarchy::Hierarchy& hierarchy = tree_->hierarchy();
  for (model::NodeId id = tree_->instances()[index].node; id != 0; id = hierarchy.find(id)->parent)
    if (nodes_.find(id) != nullptr) return true;
  return false;
}

}  // namespace sightline::scenegraph::instances
