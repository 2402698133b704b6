// A hierarchy over a mesh's triangles that is not there before somebody asks for it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "accel/published/bvh/bvh_builder.h"

namespace sightline::accel::published::bvh {

/// Hierarchies over boxes do not grow piece by piece: what is below a node has to be known before
/// its box is. The first ray that enters builds all of it, while others wait.
///
/// Threads: all members, from any.
class BvhTree {
 public:
  /// The view's arrays must outlive the tree.
  BvhTree(const geometry::MeshView& mesh, const BvhBuilder& builder)
      : mesh_(mesh), builder_(builder) {}
  ~BvhTree() { delete built_.load(std::memory_order_relaxed); }
  BvhTree(const BvhTree&) = delete;
  BvhTree& operator=(const BvhTree&) = delete;

  /// Null before it is built.
  const Bvh* built() const { return built_.load(std::memory_order_acquire); }

  /// Builds it, or waits for whoever does. Throws std::bad_alloc; the next may try again.
  const Bvh& build(kdtree::BuildCounters& counters);

  std::uint64_t bytes() const {
    const Bvh* bvh = built();
    return bvh != nullptr ? bvh->bytes() : 0;
  }

 private:
  geometry::MeshView mesh_;
  BvhBuilder builder_;
  std::mutex building_;
  std::atomic<const Bvh*> built_{nullptr};
};

}  // namespace sightline::accel::published::bvh
