// Lines are drawn where the distance, by its own slope, is within half a line of their value: so
// their edges are smooth, and they are as thick on slopes of any steepness.
#include "client/cli/picture/slice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "client/cli/picture/shading.h"

namespace sightline::client::cli::picture {
namespace {

constexpr double kLeastIsoPixels = 4;

/// A picture of this height has lines of one pixel.
constexpr double kHeightOfThinLines = 1000;

/// The width of a stripe of a hatch, in lines.
constexpr double kStripe = 4;

Rgb blend(const Rgb& below, const Rgb& above, double share) {
  const auto s = static_cast<float>(share);
  return {std::lerp(below[0], above[0], s), std::lerp(below[1], above[1], s),
          std::lerp(below[2], above[2], s)};
}

class SlicePainter {
 public:
  SlicePainter(const Slice& slice, const SliceStyle& style)
      : slice_(slice),
        style_(style),
        line_(std::max(1.0, slice.size.height / kHeightOfThinLines)) {}

  Rgb colour(std::uint32_t x, std::uint32_t y) const {
    const double distance = at(x, y);
    if (std::isnan(distance)) return kUnknown;
    if (distance == -std::numeric_limits<double>::infinity()) return hatch(x, y);
    const double position = std::clamp(distance / style_.range, -1.0, 1.0);
    const Rgb ground = side_colour(position);
    if (!std::isfinite(distance)) return ground;
    const double slope = slope_at(x, y);
    const double iso =
        style_.iso ? share_of_line(distance - nearest_iso(distance), slope, line_) : 0;
    const double outline = share_of_line(distance, slope, 2 * line_);
    return blend(blend(ground, kInk, 0.55 * iso), kInk, outline);
  }

 private:
  static constexpr Rgb kUnknown{0.35F, 0.35F, 0.35F};
  static constexpr Rgb kInk{0, 0, 0};

  /// Stripes from the lower left to the upper right: no scale has them.
  Rgb hatch(std::uint32_t x, std::uint32_t y) const {
    const auto stripe = static_cast<std::uint32_t>(std::lround(kStripe * line_));
    return (x + y) / stripe % 2 == 0 ? Rgb{0.6F, 0.6F, 0.6F} : Rgb{0.35F, 0.35F, 0.35F};
  }

  double at(std::uint32_t x, std::uint32_t y) const {
    return slice_.distances[std::size_t{y} * slice_.size.width + x];
  }

  /// The largest step to a neighbour: distances have a kink where they are 0, or where two faces
  /// are equally near, so that a mean of steps would be none. A larger step than true distances
  /// have is one of signs alone, at a hole, and no surface.
  double slope_at(std::uint32_t x, std::uint32_t y) const {
    const double here = at(x, y);
    double slope = 0;
    const auto look = [&](std::uint32_t column, std::uint32_t row) {
      const double step = std::abs(at(column, row) - here);
      if (std::isfinite(step)) slope = std::max(slope, step);
    };
    if (x > 0) look(x - 1, y);
    if (y > 0) look(x, y - 1);
    if (x + 1 < slice_.size.width) look(x + 1, y);
    if (y + 1 < slice_.size.height) look(x, y + 1);
    return std::min(slope, slice_.pixel);
  }

  /// The multiple of the step that is nearest; of 0, which has the outline, none.
  double nearest_iso(double distance) const {
    const double multiple = std::round(distance / *style_.iso);
    if (multiple == 0) return std::copysign(*style_.iso, distance);
    return multiple * *style_.iso;
  }

  /// The share of a pixel under a line where `off` is 0.
  static double share_of_line(double off, double slope, double width) {
    if (off == 0) return 1;
    return std::clamp(width / 2 + 0.5 - std::abs(off) / slope, 0.0, 1.0);
  }

  const Slice& slice_;
  const SliceStyle& style_;
  double line_;  ///< the width of an iso line in pixels
};

}  // namespace

Result<Slice> measure_slice(const Client& client, const std::string& scene, const SliceFrame& frame,
                            PictureSize size, bool is_signed, const CastOptions& options,
                            const std::function<void(double)>& progress) {
  const PointGrid grid = pixels_of(frame, size);
  Slice slice{size,
              std::max(length(grid.across), length(grid.down)),
              std::vector<double>(std::size_t{size.width} * size.height),
              {}};
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
    const auto distances = is_signed ? hits.signed_distance : hits.t;
    std::copy(distances.begin(), distances.end(),
              slice.distances.begin() + static_cast<std::ptrdiff_t>(first));
    progress(static_cast<double>(first + count) / static_cast<double>(slice.distances.size()));
    return Status();
  };
  HitFields fields;
  (is_signed ? fields.signed_distance : fields.t) = true;
  auto report = client.nearest_stream(scene, grid, fields, sink, options);
  if (!report) return report.error();
  slice.report = *std::move(report);
  return slice;
}

double range_of(std::span<const double> distances) {
  std::vector<double> sizes;
  for (const double distance : distances) {
    if (std::isfinite(distance)) sizes.push_back(std::abs(distance));
  }
  if (sizes.empty()) return 1;
  const auto rank = static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), sizes.begin() + rank, sizes.end());
  const double most = sizes[static_cast<std::size_t>(rank)];
  return most > 0 ? most : 1;
}

Rgb side_colour(double s) {
  constexpr double kBlue = 255, kRed = 30;
  const double size = std::min(std::abs(s), 1.0);
  const double darkness = 0.58 * std::sqrt(size);
  // Within sRGB for both hues: colours that lost chroma to fit would show as bands.
  const double chroma = std::min(0.16, 0.45 * darkness);
  return from_oklch(1 - darkness, chroma, s < 0 ? kBlue : kRed);
}

std::vector<std::uint8_t> paint_slice(const Slice& slice, const SliceStyle& style) {
  const SlicePainter painter(slice, style);
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * slice.distances.size());
  for (std::uint32_t y = 0; y < slice.size.height; ++y) {
    for (std::uint32_t x = 0; x < slice.size.width; ++x) {
      for (const float channel : painter.colour(x, y)) rgb.push_back(encode_srgb(channel));
    }
  }
  return rgb;
}

double least_iso(const Slice& slice) { return kLeastIsoPixels * slice.pixel; }

Scale slice_scale(const SliceStyle& style, double meters_per_unit, bool has_unanswered) {
  Scale scale = depth_scale({style.is_signed ? -style.range : 0, style.range}, meters_per_unit);
  if (style.is_signed) {
    scale.notes = {"blue is", "inside"};
    scale.colour = [](double position) { return side_colour(2 * position - 1); };
  } else {
    scale.colour = [](double position) { return side_colour(position); };
  }
  if (has_unanswered) scale.notes.insert(scale.notes.end(), {"hatched is", "no answer"});
  return scale;
}

}  // namespace sightline::client::cli::picture
