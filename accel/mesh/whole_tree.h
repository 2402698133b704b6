// The interface of trees that are built whole instead of cell by cell.
#pragma once

#include <cstdint>
#include <memory>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/mesh/mesh_stats.h"

namespace sightline::accel::mesh {

class FaceTest;

/// A tree of a paper, for comparisons: a hierarchy or a plain kd-tree (accel/published). The server
/// builds none.
/// Threads: any, all members.
class WholeTree {
 public:
  WholeTree() = default;
  virtual ~WholeTree() = default;
  WholeTree(const WholeTree&) = delete;
  WholeTree& operator=(const WholeTree&) = delete;

  virtual bool is_built() const = 0;
  /// Builds the tree, or waits for the thread that does. Throws std::bad_alloc; a later call may
  /// try again.
  virtual void build(kdtree::BuildCounters& counters) = 0;
  /// Takes the ray of `test` through the tree. Requires is_built().
  virtual void query(FaceTest& test, kdtree::WalkCounters& walked) const = 0;

  virtual std::uint64_t bytes() const = 0;
  virtual kdtree::TreeMetrics metrics() const = 0;
  /// Number of nodes and leaves once built; else 1.
  virtual std::uint64_t cells() const = 0;
};

/// Makes the tree of a mesh, not built yet. The view's arrays must outlive the tree.
class WholeTreeMaker {
 public:
  virtual ~WholeTreeMaker() = default;
  virtual std::unique_ptr<WholeTree> make(const geometry::MeshView& mesh,
                                          const MeshStats& stats) const = 0;
};

}  // namespace sightline::accel::mesh
