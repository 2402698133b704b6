// Opening a half.
#include "scenegraph/instances/scene_half.h"

namespace sightline::scenegraph::instances {

SceneHalf::~SceneHalf() { delete instances_.load(std::memory_order_acquire); }

/// Nothing is waited for that a single thread does.
const Instances& SceneHalf::instances() const {
  const Instances* now = instances_.load(std::memory_order_acquire);
  if (now == nullptr) {
    auto made = std::make_unique<const Instances>(half_, hierarchy_);
    if (instances_.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel))
      now = made.release();
  }
  now->begin();
  return *now;
}

const Instances* SceneHalf::instances_so_far() const {
  const Instances* now = instances_.load(std::memory_order_acquire);
  return now != nullptr && now->begun() ? now : nullptr;
}

}  // namespace sightline::scenegraph::instances
