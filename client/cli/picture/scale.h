// The scale beside a picture whose colours stand for numbers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/picture/shading.h"

namespace sightline::client::cli::picture {

struct Scale {
  std::string title;  ///< what the numbers are
  std::string unit;
  std::vector<std::string> notes{};  ///< lines below the colours
  ValueRange range;                  ///< in this unit
  double (*position)(double value, const ValueRange& range) = depth_position;
  Rgb (*colour)(double position) = depth_colour;
};

/// Distances: metres, or millimetres or kilometres where they read better, if the scene says how
/// long a unit is.
Scale depth_scale(const ValueRange& range, double meters_per_unit);
Scale heat_scale(const ValueRange& range);

/// Round numbers within the range, ascending: about `count`.
std::vector<double> ticks_of(const ValueRange& range, int count);

/// The columns that a scale takes of a picture of this size. 0: the picture is too small for one.
std::uint32_t scale_width(PictureSize size);

/// The size of a picture whose view has this size, with the columns of a scale added; the same if
/// the view is too small for one.
PictureSize size_with_scale(PictureSize view);

/// A picture of this size with the scale in its last scale_width(size) columns and `view` in the
/// others. `view`: sRGB, (height, width - scale_width, 3).
std::vector<std::uint8_t> beside_scale(const std::vector<std::uint8_t>& view, PictureSize size,
                                       const Scale& scale);

}  // namespace sightline::client::cli::picture
