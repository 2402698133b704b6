// Where a slice lies in its scene.
#pragma once

#include <cstddef>
#include <optional>

#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"
#include "client/points.h"
#include "client/scene_info.h"

namespace sightline::client::cli::picture {

/// A rectangle or a parallelogram: a corner, and from there its upper and its left edge.
struct SliceFrame {
  Vec3 origin{};
  Vec3 across{};
  Vec3 down{};
};

/// Of a plane that is orthogonal to an axis.
struct SlicePlane {
  std::size_t axis = 2;  ///< 0 to 2
  double at = 0;         ///< the coordinate on this axis
};

/// The frame on a plane that shows all of the scene, with a margin, in pixels that are square. The
/// axis that is up in the scene, or y, is up in the picture; where the plane is level, x runs to
/// the right, and the picture is seen from above. A scene without triangles has a square of size 1
/// at 0.
SliceFrame frame_on(const SlicePlane& plane, const SceneInfo& scene, PictureSize size);

/// Whether the frame has an area.
bool has_area(const SliceFrame& frame);

/// A point for the middle of each pixel, row by row from the top.
PointGrid pixels_of(const SliceFrame& frame, PictureSize size);

}  // namespace sightline::client::cli::picture
