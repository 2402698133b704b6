// What moves: nodes that stand elsewhere, or whose meshes are shaped otherwise, from frame to
// frame.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/double_box.h"
#include "scenegraph/model/update.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// Frames come round again after the last. Every moving node is a root and has a mesh of its own.
class Motion {
 public:
  /// `frames` is a directory of meshes with one topology, a frame a file in the order of their
  /// names, or gen:swarm?... `copies` meshes (not instances) of a directory's stand side by side,
  /// each some frames ahead of the one before. Errors: kInvalidArgument: copies of a swarm, meshes
  /// that differ in topology; kNotFound: no directory, no mesh in it.
  static Result<Motion> make(const std::string& frames, std::size_t copies);

  std::size_t frames() const { return frames_; }
  std::size_t nodes() const { return parts_.nodes.size(); }
  bool rigid() const { return shapes_.empty(); }
  std::uint64_t triangles() const { return parts_.unique_triangles(); }
  /// Holds everything in every frame.
  const scenegraph::model::DoubleBox& bounds() const { return bounds_; }

  /// In frame 0, with the mobility that suits.
  const SceneSource& parts() const { return parts_; }
  const scenegraph::model::Affine& place(std::size_t node, std::size_t frame) const;
  const std::vector<accel::geometry::Vec3f>& vertices(std::size_t node, std::size_t frame) const;

  /// Brings a scene, in which the first of these nodes has the id `first`, to that frame.
  std::vector<scenegraph::model::Update> updates(std::size_t frame,
                                                 scenegraph::model::NodeId first) const;
  /// The same for arrays, where the first of these nodes has this place.
  void pose(SceneSource& scene, std::size_t first_node, std::size_t frame) const;

 private:
  static Result<Motion> load(const std::string& directory, std::size_t copies);
  static Result<Motion> swarm(const std::string& generator);
  std::size_t shape(std::size_t node, std::size_t frame) const;
  void measure();

  SceneSource parts_;
  std::size_t frames_ = 0;
  std::vector<std::vector<scenegraph::model::Affine>> places_;  // frame, node; of rigid motion
  std::vector<std::vector<accel::geometry::Vec3f>> shapes_;     // by frame; of deformation
  scenegraph::model::DoubleBox bounds_;
};

}  // namespace sightline::bench
