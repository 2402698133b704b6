// A motion: nodes whose transforms or vertices change from frame to frame.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/double_box.h"
#include "scenegraph/model/update.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// Frames repeat after the last one. Every moving node is a root with its own mesh.
class Motion {
 public:
  /// `frames` is a directory of meshes with one topology, one file a frame in the order of their
  /// names, or gen:swarm?... `copies` meshes (not instances) of a directory stand side by side,
  /// each some frames ahead of the one before. Errors: kInvalidArgument: copies of a swarm, meshes
  /// that differ in topology; kNotFound: no directory, no mesh in it.
  static Result<Motion> make(const std::string& frames, std::size_t copies);

  std::size_t frames() const { return frames_; }
  std::size_t nodes() const { return parts_.nodes.size(); }
  bool rigid() const { return shapes_.empty(); }
  std::uint64_t triangles() const { return parts_.unique_triangles(); }
  /// Contains all nodes in all frames.
  const scenegraph::model::DoubleBox& bounds() const { return bounds_; }

  /// The moving nodes in frame 0, with suitable mobility.
  const SceneSource& parts() const { return parts_; }
  const scenegraph::model::Affine& transform(std::size_t node, std::size_t frame) const;
  const std::vector<accel::geometry::Vec3f>& vertices(std::size_t node, std::size_t frame) const;

  /// Sets a scene to the frame; `first` is the id of the first moving node.
  std::vector<scenegraph::model::Update> updates(std::size_t frame,
                                                 scenegraph::model::NodeId first) const;
  /// The same for arrays; `first` is the index of the first moving node.
  void pose(SceneSource& scene, std::size_t first_node, std::size_t frame) const;

 private:
  static Result<Motion> load(const std::string& directory, std::size_t copies);
  static Result<Motion> swarm(const std::string& generator);
  std::size_t shape(std::size_t node, std::size_t frame) const;
  void measure();

  SceneSource parts_;
  std::size_t frames_ = 0;
  std::vector<std::vector<scenegraph::model::Affine>>
      transforms_;                                           // By frame and node; rigid motion only
  std::vector<std::vector<accel::geometry::Vec3f>> shapes_;  // By frame; deformation only
  scenegraph::model::DoubleBox bounds_;
};

}  // namespace sightline::bench
