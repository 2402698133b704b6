// The directions of side rays.
#include "scenegraph/side_rule.h"

#include <array>
#include <cmath>

namespace sightline::scenegraph {
namespace {

using accel::geometry::Vec3d;

/// The directions of side rays, of length 1: heights and angles are two sequences whose first n
/// numbers are spread evenly, for any n (Roberts 2018, R2). They are not axes nor diagonals.
/// Angles are turned by products alone: sine and cosine differ between libraries.
std::array<Vec3d, kMaxSideRays> make_directions() {
  constexpr double kHeightStep = 0.7548776662466927;
  // The cosine and sine of 0.5698402909980532 turns.
  constexpr double kCosine = -0.9052538583630299, kSine = -0.4248711003573289;
  std::array<Vec3d, kMaxSideRays> directions;
  double height = 0.5, x = 1, y = 0;
  for (Vec3d& direction : directions) {
    height += kHeightStep;
    if (height >= 1) height -= 1;
    const double turned = x * kCosine - y * kSine;
    y = x * kSine + y * kCosine;
    x = turned;
    const double z = 1 - 2 * height, radius = std::sqrt(1 - z * z);
    direction = {radius * x, radius * y, z};
  }
  return directions;
}

}  // namespace

const Vec3d& side_direction(std::uint32_t ray) {
  static const std::array<Vec3d, kMaxSideRays> kDirections = make_directions();
  return kDirections[ray];
}

}  // namespace sightline::scenegraph
