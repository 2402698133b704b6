// Small letters and digits as pixels.
#pragma once

#include <array>
#include <cstdint>

namespace sightline::client::cli::picture {

inline constexpr std::uint32_t kGlyphWidth = 5, kGlyphHeight = 7;  ///< pixels
inline constexpr std::uint32_t kGlyphStep = 6;                     ///< from one letter to the next

/// Rows from the top; the highest of the kGlyphWidth bits is the left pixel.
using Glyph = std::array<std::uint8_t, kGlyphHeight>;

/// The glyph of a character; empty if the font does not have it. It has digits, the letters of
/// units and of the words on a scale, '.', '-' and '+'.
Glyph glyph_of(char c);

}  // namespace sightline::client::cli::picture
