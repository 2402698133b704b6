// What a face adds to the pseudonormal of a surface at a point: its normal, weighted by its angle
// there (Baerentzen, Aanaes 2005).
#pragma once

#include <array>

#include "accel/geometry/closest_feature.h"
#include "accel/geometry/seen_face.h"

namespace sightline::accel::geometry {

/// A face in the scene, as seen from a point.
struct FaceNormal {
  SeenFace seen;
  /// The normal of length 1, from which the corners are seen counterclockwise; 0 without area.
  Vec3dd normal;
  DoubleDouble area;  ///< Twice the face's area.
};

/// The point x of a face that is nearest to a point p.
struct NearestPoint {
  Feature feature;  ///< What of the face x is on.
  Vec3dd from_p;    ///< x - p, divided by a power of two that is about its length.
  Vec3d position;   ///< x, rounded.
  double off = 0;   ///< How far `position` is off at most on each axis.
  Vec3d view;       ///< Where faces that may contain x are to be seen from: p, or x if p is far.
  Vec3dd seen;      ///< x - view.
  double seen_off = 0;  ///< How far `seen` may be off, with a margin.
};

/// Describes the face with corners M a, M b, M c, as seen from p; arguments are those of
/// distance(). False if double-doubles may be off by more than 2^-44 of the normal's length.
bool computed_normal(const Vec3d& p, const std::array<double, 12>& world_from_local,
                     const std::array<Vec3f, 3>& vertices, FaceNormal& face);
/// In integers; what is returned is off by less than 2^-92.
FaceNormal exact_normal(const Vec3d& p, const std::array<double, 12>& world_from_local,
                        const std::array<Vec3f, 3>& vertices);

/// The nearest point of a face; `distance` is that of distance(), and positive. False if
/// double-doubles do not tell the feature, or may be off by more than 2^-44 of the distance.
bool computed_nearest(const Vec3d& p, const std::array<double, 12>& world_from_local,
                      const std::array<Vec3f, 3>& vertices, double distance, NearestPoint& nearest);
/// In integers; what is returned is off by less than 2^-92.
NearestPoint exact_nearest(const Vec3d& p, const std::array<double, 12>& world_from_local,
                           const std::array<Vec3f, 3>& vertices, double distance);

/// The face's angle at a corner, on an edge (pi), or inside (2 pi).
DoubleDouble angle_at(const FaceNormal& face, const Feature& feature);
/// Where on the face a point is, of which the same point sees the face; kUnknown if the face does
/// not contain it. `off` is how far the point may be off.
Feature part_at(const FaceNormal& face, const Vec3dd& point, double off);

/// Whether a matrix that has an inverse mirrors space.
bool is_mirrored(const std::array<double, 12>& world_from_local);

/// The length of the longest edge of the face, within a factor of 2.
double longest_edge(const std::array<double, 12>& world_from_local,
                    const std::array<Vec3f, 3>& vertices);

/// Sets off, view, seen and seen_off of a nearest point whose position is set; `from_p` and `error`
/// in units of 1, `reach` the distance of the farthest corner.
void set_view(const Vec3d& p, const Vec3dd& from_p, double error, double reach, double longest,
              NearestPoint& nearest);

}  // namespace sightline::accel::geometry
