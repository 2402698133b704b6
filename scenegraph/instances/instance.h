// An instance as rays meet it.
#pragma once

#include <atomic>
#include <cstdint>

#include "accel/geometry/aabb.h"
#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/model/node.h"

namespace sightline::scenegraph::instances {

/// A node that has a mesh with a finite triangle, with its world transform.
struct Instance {
  model::Affine local_from_world;
  accel::geometry::Aabb box;  ///< The world box, relative to Instances::center(), rounded outward.
  model::NodeId node = 0;
  model::NodeId parent = 0;
  std::uint32_t mask = accel::geometry::kAllMasks;
  std::uint32_t index = 0;  ///< Its index among Instances.
  const model::Mesh* mesh = nullptr;
  std::atomic<bool>* entered = nullptr;

  void mark_entered() const {
    if (!entered->load(std::memory_order_relaxed)) entered->store(true, std::memory_order_relaxed);
  }
};

}  // namespace sightline::scenegraph::instances
