// The colour of a sample, from what its ray hit. Colours are linear sRGB, 0 to 1.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/cli/picture/camera.h"
#include "client/scene_info.h"

namespace sightline::client::cli::picture {

using Rgb = std::array<float, 3>;

/// Lightness 0 to 1, chroma 0 to about 0.3, hue in degrees. Colours outside sRGB lose chroma until
/// they fit.
Rgb from_oklch(double lightness, double chroma, double hue);

/// From near black through violet and orange to pale yellow, lightness rising evenly. s from 0
/// to 1.
Rgb heat_colour(double s);

/// From pale sand (near, 0) through green and blue to deep indigo (far, 1), lightness falling
/// evenly.
Rgb depth_colour(double s);

/// The same colour for the same id, always; ids that follow one another get hues far apart.
Rgb node_colour(std::uint64_t id);

/// What the display wants: gamma, 0 to 255.
std::uint8_t encode_srgb(float linear);

/// The normal, turned to the side that the ray comes from.
Vec3 facing(const Vec3& normal, const Vec3& direction);

/// Light on a surface from beside and above the camera, 0 to 1. `normal` faces the camera.
double light_on(const Vec3& normal, const Camera& camera);

/// A pastel colour for the direction of a normal, lit. The same for "up" whichever axis is up.
Rgb normal_shade(const Vec3& normal, const Camera& camera, UpAxis up);

/// The node's own colour, lit.
Rgb node_shade(std::uint64_t node, const Vec3& normal, const Camera& camera);

/// Behind the scene, where y runs from 0 at the top of the picture to 1.
Rgb backdrop(double y);

/// A sample of a picture whose colours depend on the range of its values.
struct Sample {
  float value = 0;
  float light = 0;  ///< Below 0: nothing was hit.
  bool unbuilt = false;
};

/// Distance as colour, between those that all but the outermost hundredths of the samples have.
std::vector<Rgb> depth_shades(const std::vector<Sample>& samples);

/// Work as colour. What is not built stays dark.
std::vector<Rgb> heat_shades(const std::vector<Sample>& samples);

}  // namespace sightline::client::cli::picture
