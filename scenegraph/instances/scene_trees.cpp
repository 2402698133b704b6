// Makes a tree's instances at the first ray, and looks up the hierarchy for removed nodes.
#include "scenegraph/instances/scene_trees.h"

#include <algorithm>

namespace sightline::scenegraph::instances {
namespace {

/// An upper bound on the tree's number of instances. A writer asks for it, and does not wait for
/// rays that are opening the tree.
std::size_t most_instances(const SceneTree& tree) {
  const Instances* opened = tree.instances_so_far();
  return opened != nullptr ? opened->size() : tree.hierarchy().summary(0).instances;
}

}  // namespace

SceneTree::~SceneTree() { delete instances_.load(std::memory_order_acquire); }

std::shared_ptr<const MovedNodes> SceneTree::moved() const {
  const std::lock_guard lock(moved_mutex_);
  return moved_;
}

/// No thread waits for another: several may make the instances, and the first result is kept. Each
/// that makes them keeps the parts until it is done.
const Instances& SceneTree::instances() const {
  if (const Instances* opened = instances_so_far()) return *opened;
  wanted_.store(true, std::memory_order_relaxed);
  const std::shared_ptr<const MovedNodes> moved = this->moved();
  const Instances* now = instances_.load(std::memory_order_acquire);
  if (now == nullptr) {
    auto made = std::make_unique<const Instances>(hierarchy_, moved.get());
    if (instances_.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel))
      now = made.release();
  }
  now->begin();
  std::shared_ptr<const MovedNodes> released;  // outside the lock: freeing it may take long
  const std::lock_guard lock(moved_mutex_);
  released.swap(moved_);
  return *now;
}

const Instances* SceneTree::instances_so_far() const {
  const Instances* now = instances_.load(std::memory_order_acquire);
  return now != nullptr && now->begun() ? now : nullptr;
}

RemovedFilter::RemovedFilter(std::shared_ptr<const SceneTree> tree, std::uint64_t last,
                             hierarchy::ChangeMap changed_at)
    : tree_(std::move(tree)),
      last_(last),
      changed_at_(std::move(changed_at)),
      removed_(most_instances(*tree_)) {}

bool RemovedFilter::decide(std::size_t index) const {
  const Instance& instance = tree_->instances()[index];
  const auto changed = [&](model::NodeId id) {
    const std::uint64_t* at = changed_at_.find(id);
    return at != nullptr && *at > last_;
  };
  return changed(instance.node) || any_upward(tree_->hierarchy(), instance.parent, changed);
}

bool SceneTrees::are_opened() const {
  return std::all_of(levels.begin(), levels.end(),
                     [](const Level& level) { return level.tree->instances_so_far() != nullptr; });
}

OpenTrees::OpenTrees(const SceneTrees& trees) {
  trees_.reserve(trees.levels.size());
  for (const Level& level : trees.levels) {
    trees_.push_back({level.tree->instances(), level.removed.get(), size_});
    size_ += trees_.back().instances.size();
  }
}

}  // namespace sightline::scenegraph::instances
