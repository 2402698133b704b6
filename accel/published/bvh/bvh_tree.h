// A hierarchy over a mesh's triangles, built by the first ray that enters it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "accel/mesh/whole_tree.h"
#include "accel/published/bvh/bvh_builder.h"

namespace sightline::accel::published::bvh {

/// A hierarchy is not built lazily, because the box of a node depends on all that is below it. The
/// first ray that enters builds all of it, while others wait.
class BvhTree final : public mesh::WholeTree {
 public:
  /// The view's arrays must outlive the tree.
  BvhTree(const geometry::MeshView& mesh, const BvhBuilder& builder)
      : mesh_(mesh), builder_(builder) {}
  ~BvhTree() override { delete built_.load(std::memory_order_relaxed); }

  /// The hierarchy; null before it is built.
  const Bvh* built() const { return built_.load(std::memory_order_acquire); }

  bool is_built() const override { return built() != nullptr; }
  void build(kdtree::BuildCounters& counters) override;
  void query(mesh::FaceTest& test, kdtree::WalkCounters& walked) const override;
  std::uint64_t bytes() const override { return is_built() ? built()->bytes() : 0; }
  kdtree::TreeMetrics metrics() const override;
  std::uint64_t cells() const override { return is_built() ? 2 * built()->nodes.size() + 1 : 1; }

 private:
  geometry::MeshView mesh_;
  BvhBuilder builder_;
  std::mutex building_;
  std::atomic<const Bvh*> built_{nullptr};
};

}  // namespace sightline::accel::published::bvh
