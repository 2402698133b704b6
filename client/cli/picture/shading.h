// The colour of a sample, from what its ray hit. Colours are linear sRGB, 0 to 1.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/cli/picture/camera.h"

namespace sightline::client::cli::picture {

using Rgb = std::array<float, 3>;

/// Lightness 0 to 1, chroma 0 to about 0.3, hue in degrees. Colours outside sRGB lose chroma until
/// they fit. In OKLCh, equal steps look equal.
Rgb from_oklch(double lightness, double chroma, double hue);

/// A colour from near black through violet and orange to pale yellow. Lightness rises evenly. s
/// runs from 0 to 1.
Rgb heat_colour(double s);

/// A colour from pale sand (near, 0) through green and blue to deep indigo (far, 1). Lightness
/// falls evenly.
Rgb depth_colour(double s);

/// A colour from dark red (0, where things touch) through orange to pale yellow (1). Lightness
/// rises evenly, and tells the distance to those who see no red.
Rgb clearance_colour(double s);

/// A colour that is always the same for the same id. Consecutive ids get distant hues.
Rgb node_colour(std::uint64_t id);

/// Applies the gamma of sRGB. Returns 0 to 255.
std::uint8_t encode_srgb(float linear);

/// The normal, turned to the side from which the ray comes.
Vec3 facing(const Vec3& normal, const Vec3& direction);

/// Light on a surface from a lamp beside and above the camera, 0 to 1. `normal` faces the camera.
double light_on(const Vec3& normal, const Camera& camera);

/// A pastel colour for the direction of a normal, with light. "Up" always has the same colour.
Rgb normal_shade(const Vec3& normal, const Camera& camera);

/// The node's own colour, with light.
Rgb node_shade(std::uint64_t node, const Vec3& normal, const Camera& camera);

/// Clay under a sun, a sky, and a weak lamp at the camera. `sun` is the unit direction to the sun.
Rgb sun_shade(const Vec3& normal, const Vec3& sun, bool in_shadow, const Camera& camera);

/// The colour behind the scene. y runs from 0 at the top of the picture to 1.
Rgb backdrop(double y);

/// A sample of a picture whose colours depend on the range of its values.
struct Sample {
  float value = 0;
  float light = 0;  ///< below 0: a miss
  bool deferred = false;
};

/// The values with the first and the last colour.
struct ValueRange {
  double low = 0;
  double high = 1;  ///< above `low`
};

/// The range of distances, without the nearest and the farthest hundredth.
ValueRange depth_range(const std::vector<Sample>& samples);
/// The range of work, from 0 on, without the few samples with the most.
ValueRange heat_range(const std::vector<Sample>& samples);

/// Where a value stands in its range, 0 to 1: evenly, or by the square root for heat, so that
/// little work differs too.
double depth_position(double value, const ValueRange& range);
double heat_position(double value, const ValueRange& range);

/// Colours for distances.
std::vector<Rgb> depth_shades(const std::vector<Sample>& samples, const ValueRange& range);

/// The colour for a distance from everything else; grey where it is infinite.
Rgb clearance_shade(const Sample& sample, const ValueRange& range);

/// Pale grey, for what is there for orientation alone. `light`: 0 to 1.
Rgb context_shade(double light);

/// Colours for work. Unbuilt cells stay dark.
std::vector<Rgb> heat_shades(const std::vector<Sample>& samples, const ValueRange& range);

}  // namespace sightline::client::cli::picture
