// The distances of the points of a slice, and their picture.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/picture/scale.h"
#include "client/cli/picture/slice_frame.h"
#include "client/client.h"
#include "client/result.h"

namespace sightline::client::cli::picture {

/// Distances, row by row from the top. -inf: a point without an answer.
struct Slice {
  PictureSize size;
  /// The larger step from a pixel to the next. True distances differ by no more than it.
  double pixel = 0;
  std::vector<double> distances;
  CastReport report;
};

/// Asks for the distance at the middle of each pixel: signed, or not. `progress` is called with the
/// part that is done, 0 to 1, on the calling thread.
Result<Slice> measure_slice(const Client& client, const std::string& scene, const SliceFrame& frame,
                            PictureSize size, bool is_signed, const CastOptions& options,
                            const std::function<void(double)>& progress);

/// How distances become colours.
struct SliceStyle {
  bool is_signed = true;
  double range = 1;             ///< the distance with the last colour
  std::optional<double> iso{};  ///< a line at each multiple of it
};

/// A distance that is larger than nearly all of the slice, for SliceStyle::range.
double range_of(std::span<const double> distances);

/// White at 0, ever darker blue to -1 and red to 1: lightness alone tells how far, and hue the
/// side. Both change most near 0, so that thin walls show their side.
Rgb side_colour(double s);

/// sRGB, (height, width, 3): colours by distance, black at 0, and lines at the multiples of
/// SliceStyle::iso. Points without a distance are grey, and those without an answer are hatched.
std::vector<std::uint8_t> paint_slice(const Slice& slice, const SliceStyle& style);

/// The least distance between iso lines that can be told from each other: a few pixels.
double least_iso(const Slice& slice);

/// The colours of a style, in the unit that depth_scale() takes. `has_unanswered`: the scale says
/// what is hatched.
Scale slice_scale(const SliceStyle& style, double meters_per_unit, bool has_unanswered = false);

}  // namespace sightline::client::cli::picture
