// A scene's arrays in the layout that Embree needs.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// A mesh, and the nodes that have it.
struct EmbreeMesh {
  std::vector<accel::geometry::Vec3f> vertices;  ///< The last one is padding.
  std::vector<accel::geometry::Face> faces;
  std::uint64_t triangles = 0;  ///< Faces that are finite triangles.
  struct Use {
    std::uint64_t node;
    scenegraph::model::Affine frame_from_local;
  };
  std::vector<Use> uses;
  bool instanced() const { return uses.size() > 1; }
};

/// Transforms from the world to a frame that rotates with the scene's first node but does not move
/// with it.
scenegraph::model::Affine embree_frame(const SceneSource& scene);

/// In the order of the scene's meshes. If only one node has a mesh, the mesh's vertices are
/// transformed to the frame.
std::vector<EmbreeMesh> lay_out_for_embree(const SceneSource& scene,
                                           const scenegraph::model::Affine& frame);

}  // namespace sightline::bench
