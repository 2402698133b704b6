// A plain kd-tree over a mesh's triangles, built by the first ray that enters it.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>

#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/whole_tree.h"
#include "accel/published/kd/plain_cells.h"
#include "accel/published/kd/plain_rule.h"

namespace sightline::accel::published::kd {

/// A plain tree is built whole, down to leaves, as in the papers. The first ray that enters builds
/// all of it, while others wait.
class PlainTree final : public mesh::WholeTree {
 public:
  /// The view's arrays must outlive the tree.
  PlainTree(const geometry::MeshView& mesh, const mesh::MeshStats& stats, const PlainRule& rule);
  ~PlainTree() override { delete built_.load(std::memory_order_relaxed); }

  /// The cells; null before they are built.
  const PlainCells* built() const { return built_.load(std::memory_order_acquire); }
  /// The cell of the root.
  const geometry::Aabb& bounds() const { return bounds_; }

  bool is_built() const override { return built() != nullptr; }
  void build(kdtree::BuildCounters& counters) override;
  void query(mesh::FaceTest& test, kdtree::WalkCounters& walked) const override;
  std::uint64_t bytes() const override { return is_built() ? built()->bytes() : 0; }
  kdtree::TreeMetrics metrics() const override;
  std::uint64_t cells() const override { return is_built() ? 2 * built()->pairs.size() + 1 : 1; }

 private:
  PlainCells grow(kdtree::BuildCounters& counters) const;

  geometry::MeshView mesh_;
  geometry::Aabb bounds_;
  PlainRule rule_;
  std::mutex building_;
  std::atomic<const PlainCells*> built_{nullptr};
};

}  // namespace sightline::accel::published::kd
