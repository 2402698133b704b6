// Scenes for points, and fresh trees over them.
#pragma once

#include <memory>
#include <vector>

#include "accel/kdtree/tree_memory.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/model/mesh.h"
#include "scenegraph/revision/snapshot.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// A mesh, and the frames of the nodes that have it.
struct ScenePart {
  TestMesh mesh;
  std::vector<scenegraph::model::Affine> frames{{}};
};

/// A scene whose trees nothing has grown yet. They count in a memory of their own.
class FreshScene {
 public:
  explicit FreshScene(const std::vector<ScenePart>& parts);

  const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot() const {
    return snapshot_;
  }
  /// The number of faces, over all nodes.
  std::size_t faces() const { return faces_; }
  /// Builds all trees of meshes and the one over the nodes, also where a full build would make one
  /// flat tree of all.
  void build_meshes() const;
  /// Evicts half of the bytes of the meshes' trees.
  void cool() const;

 private:
  std::shared_ptr<accel::kdtree::TreeMemory> memory_;
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes_;
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  std::size_t faces_ = 0;
};

/// A frame whose axes are orthogonal up to rounding, turned in any way, and of these lengths.
scenegraph::model::Affine turned(Random& random, const accel::geometry::Vec3d& lengths,
                                 const accel::geometry::Vec3d& offset);
scenegraph::model::Affine placed_at(const accel::geometry::Vec3d& offset, double scale = 1);

/// The mesh with its vertices rounded to multiples of `step`.
TestMesh on_grid(TestMesh mesh, float step);
TestMesh scaled(TestMesh mesh, float scale, const accel::geometry::Vec3f& offset = {});
/// A tube of radius 1 around the z axis from 0 to `rings`: `corners` (a power of two) faces for
/// each half of a ring.
TestMesh tube(std::uint32_t corners, std::uint32_t rings);
/// Triangles as long as 1e8 times their width.
TestMesh long_needles(std::uint32_t triangles, std::uint64_t seed);
/// Points, segments from one vertex to another and back, and collinear triangles.
TestMesh points_and_segments(std::uint32_t faces, std::uint64_t seed);
/// Every face three times: as it is, turned to its next corner, and with the other winding.
TestMesh tripled(const TestMesh& mesh);
/// Triangles of whole coordinates in planes whose normals have whole lengths, and in planes across
/// the x axis at odd halves: points have whole distances from them, or halves of an ulp.
TestMesh whole_planes();

}  // namespace sightline::tests
