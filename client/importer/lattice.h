// Where the vertices of a mesh may lie, so that float holds them and meshes that touch still touch.
#pragma once

#include <vector>

#include "client/importer/file_scene.h"

namespace sightline::client::importer {

/// Bounds of finite vertices.
struct VertexBox {
  Point lo, hi;  ///< lo > hi if there is none

  VertexBox();
  void add(const Point& vertex);  ///< ignored if it is not finite
  void add(const VertexBox& other);
  double size() const;  ///< the largest extent; negative if there is none
  Point reach() const;  ///< the largest distance from zero on each axis
};

/// The box of the vertices that faces name, or of all if there are no faces.
VertexBox box_of(const FileMesh& mesh);

/// The rule by which positions in double become an offset and floats. It looks at nothing but a
/// coordinate and one step, a power of two, so that a vertex that two meshes of one step share, in
/// one file or in two, is at one position. client/python/sightline/_lattice.py has the rule, too.
///
/// - A coordinate within kFarSteps steps of zero becomes the nearest float.
/// - One that lies farther out becomes the nearest multiple of 2^-24 steps; of two, the even one.
/// - On an axis where a mesh is wholly within kFarSteps steps of zero its offset is 0, else the
///   multiple of the step nearest to its middle.
///
/// A mesh that is at most a step in size is then an offset and floats without further rounding:
/// each rounded coordinate is at most a step away from the offset, and both are multiples of 2^-24
/// steps. A coordinate that is a float does not change.
class LatticeStep {
 public:
  static constexpr double kFarSteps = 16;

  /// An infinite step: all coordinates become floats.
  LatticeStep();
  /// The step of a mesh or a scene whose meshes lie in this box, and have this size at most. At
  /// 4,000,000 all meshes of 1.3 to 4,096 units have the step 4,096. Sizes and distances that are
  /// 16 times as large have one that is.
  LatticeStep(double size, const Point& reach);

  double value() const { return step_; }
  /// How far rounding moves coordinates at these distances from zero, at most.
  double error(const Point& reach) const;
  double rounded(double coordinate) const;
  Point offset(const VertexBox& box) const;

 private:
  double step_;
};

}  // namespace sightline::client::importer
