// Makes a tree's instances at the first ray, and looks up the hierarchy for removed nodes.
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::instances {

SceneTree::~SceneTree() { delete instances_.load(std::memory_order_acquire); }

/// Never blocks on another thread: the first result is kept.
const Instances& SceneTree::instances() const {
  const Instances* now = instances_.load(std::memory_order_acquire);
  if (now == nullptr) {
    auto made = std::make_unique<const Instances>(side_, hierarchy_);
    if (instances_.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel))
      now = made.release();
  }
  now->begin();
  return *now;
}

const Instances* SceneTree::instances_so_far() const {
  const Instances* now = instances_.load(std::memory_order_acquire);
  return now != nullptr && now->begun() ? now : nullptr;
}

RemovedFilter::RemovedFilter(std::shared_ptr<const SceneTree> tree, NodeSet nodes)
    : tree_(std::move(tree)), nodes_(std::move(nodes)), removed_(tree_->instances().size()) {}

bool RemovedFilter::decide(std::size_t index) const {
  return any_upward(tree_->hierarchy(), tree_->instances()[index].node,
                    [&](model::NodeId id) { return nodes_.find(id) != nullptr; });
}

}  // namespace sightline::scenegraph::instances
