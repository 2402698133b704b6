// Colours, chosen in OKLCh so that equal steps look equal. All are linear sRGB, 0 to 1.
#pragma once

#include <array>
#include <cstdint>

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

}  // namespace sightline::client::cli::picture
