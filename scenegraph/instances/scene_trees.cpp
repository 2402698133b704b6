// Makes a tree's instances at the first ray.
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

}  // namespace sightline::scenegraph::instances
