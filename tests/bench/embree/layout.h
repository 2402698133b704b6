// A scene's arrays as Embree is given them.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// A mesh, and the nodes that carry it.
struct EmbreeMesh {
  std::vector<accel::geometry::Vec3f> vertices;  ///< The last one is padding.
  std::vector<accel::geometry::Face> faces;
  std::uint64_t triangles = 0;  ///< Faces that are some.
  struct Use {
    std::uint64_t node;
    scenegraph::model::Affine frame_from_local;
  };
  std::vector<Use> uses;
  bool instanced() const { return uses.size() > 1; }
};

/// From the world to a frame that turns with the scene's first node and does not move with it.
scenegraph::model::Affine embree_frame(const SceneSource& scene);

/// In the order of the scene's meshes. The vertices of a mesh that one node carries are laid in the
/// frame.
std::vector<EmbreeMesh> lay_out_for_embree(const SceneSource& scene,
                                           const scenegraph::model::Affine& frame);

}  // namespace sightline::bench
