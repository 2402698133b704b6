// Lays out the title, the colours and the numbers from top to bottom.
#include "client/cli/picture/scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "client/cli/picture/font.h"

namespace sightline::client::cli::picture {
namespace {

// Lengths in pixels of the font, which are `zoom` pixels of the picture wide.
constexpr std::uint32_t kBarLeft = 6, kBarWidth = 12, kTickWidth = 3, kTextLeft = 24;
constexpr std::uint32_t kWidth = 76, kLine = 11, kEdge = 8;
constexpr std::uint32_t kLeastHeight = 100, kLeastView = 2 * kWidth, kLeastBar = 2 * kGlyphHeight;
constexpr std::uint32_t kHeightOfZoom = 360;  // a picture's, for each step of zoom

std::uint32_t zoom_of(PictureSize size) {
  return std::max(1U, (size.height + kHeightOfZoom / 2) / kHeightOfZoom);
}

// The panel of the scale, as a part of the whole picture.
class Panel {
 public:
  Panel(std::vector<std::uint8_t>& rgb, PictureSize size)
      : rgb_(rgb), size_(size), zoom_(zoom_of(size)), left_(size.width - scale_width(size)) {}

  std::uint32_t height() const { return size_.height / zoom_; }

  void fill(std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height,
            const Rgb& colour) {
    for (std::uint32_t row = y * zoom_; row < (y + height) * zoom_ && row < size_.height; ++row) {
      for (std::uint32_t column = left_ + x * zoom_;
           column < left_ + (x + width) * zoom_ && column < size_.width; ++column)
        set(column, row, colour);
    }
  }

  void background(const Rgb& colour) {
    for (std::uint32_t row = 0; row < size_.height; ++row) {
      for (std::uint32_t column = left_; column < size_.width; ++column) set(column, row, colour);
    }
  }

  void text(std::uint32_t x, std::uint32_t y, std::string_view words, const Rgb& colour) {
    for (const char c : words) {
      const Glyph glyph = glyph_of(c);
      for (std::uint32_t row = 0; row < kGlyphHeight; ++row) {
        for (std::uint32_t column = 0; column < kGlyphWidth; ++column) {
          if ((glyph[row] >> (kGlyphWidth - 1 - column) & 1U) != 0)
            fill(x + column, y + row, 1, 1, colour);
        }
      }
      x += kGlyphStep;
    }
  }

 private:
  void set(std::uint32_t x, std::uint32_t y, const Rgb& colour) {
    for (std::size_t k = 0; k < 3; ++k)
      rgb_[3 * (std::size_t{y} * size_.width + x) + k] = encode_srgb(colour[k]);
  }

  std::vector<std::uint8_t>& rgb_;
  PictureSize size_;
  std::uint32_t zoom_;
  std::uint32_t left_;
};

// The number as text that is short enough for the panel.
std::string number_text(double value) {
  if (std::abs(value) >= 1e6 || (value != 0 && std::abs(value) < 1e-3))
    return fmt::format("{:.2g}", value);
  return fmt::format("{:.6g}", value);
}

void draw_numbers(Panel& panel, const Scale& scale, std::uint32_t top, std::uint32_t height,
                  const Rgb& ink) {
  const int count = std::clamp(static_cast<int>(height / 40), 3, 8);
  std::uint32_t free = top + height + kLine;  // numbers go from the bottom to the top
  for (const double tick : ticks_of(scale.range, count)) {
    const double position = scale.position(tick, scale.range);
    const auto y = top + static_cast<std::uint32_t>(std::lround((1 - position) * (height - 1)));
    if (y + kLine > free) continue;
    panel.fill(kBarLeft + kBarWidth, y, kTickWidth, 1, ink);
    panel.text(kTextLeft, y - kGlyphHeight / 2, number_text(tick), ink);
    free = y;
  }
}

// The first notes, as many as leave room for the colours above them.
std::vector<std::string> notes_that_fit(std::vector<std::string> notes, std::uint32_t height) {
  const std::size_t lines = (height - kEdge - kLine - kLeastBar) / kLine;
  if (notes.size() > lines) notes.resize(lines);
  return notes;
}

}  // namespace

Scale depth_scale(const ValueRange& range, double meters_per_unit) {
  Scale scale{.title = "distance", .unit = "units", .range = range};
  if (!(meters_per_unit > 0)) return scale;
  const double farthest = range.high * meters_per_unit;
  double factor = meters_per_unit;
  scale.unit = "m";
  if (farthest < 0.5) {
    scale.unit = "mm";
    factor *= 1e3;
  } else if (farthest > 2e4) {
    scale.unit = "km";
    factor *= 1e-3;
  }
  scale.range = {range.low * factor, range.high * factor};
  return scale;
}

Scale heat_scale(const ValueRange& range) {
  return {.title = "work a ray",
          .unit = "steps+tests",
          .notes = {"dark is", "not built"},
          .range = range,
          .position = heat_position,
          .colour = heat_colour};
}

std::vector<double> ticks_of(const ValueRange& range, int count) {
  const double rough = (range.high - range.low) / count;
  if (!(rough > 0) || !std::isfinite(rough)) return {};
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough) step = factor * power;
  }
  std::vector<double> ticks;
  const double first = std::ceil(range.low / step - 1e-9);
  const double last = std::floor(range.high / step + 1e-9);
  // There are more than a few only by rounding, where the range is far from 0 and narrow.
  for (double i = first; i <= last && ticks.size() <= 2 * static_cast<std::size_t>(count); ++i)
    ticks.push_back(i * step + 0.0);
  return ticks;
}

std::uint32_t scale_width(PictureSize size) {
  const std::uint32_t zoom = zoom_of(size);
  if (size.height < kLeastHeight * zoom || size.width < (kLeastView + kWidth) * zoom) return 0;
  return kWidth * zoom;
}

PictureSize size_with_scale(PictureSize view) {
  const PictureSize whole{view.width + kWidth * zoom_of(view), view.height};
  return scale_width(whole) > 0 ? whole : view;
}

std::vector<std::uint8_t> beside_scale(const std::vector<std::uint8_t>& view, PictureSize size,
                                       const Scale& scale) {
  const std::size_t width = size.width, view_width = size.width - scale_width(size);
  std::vector<std::uint8_t> rgb(3 * width * size.height);
  for (std::size_t row = 0; row < size.height; ++row) {
    std::copy_n(view.begin() + static_cast<std::ptrdiff_t>(3 * row * view_width), 3 * view_width,
                rgb.begin() + static_cast<std::ptrdiff_t>(3 * row * width));
  }
  Panel panel(rgb, size);
  const Rgb paper = from_oklch(0.98, 0.003, 250), ink = from_oklch(0.3, 0.02, 270);
  panel.background(paper);
  panel.text(kBarLeft, kEdge, scale.title, ink);
  panel.text(kBarLeft, kEdge + kLine, scale.unit, ink);
  const std::uint32_t top = kEdge + 3 * kLine;
  const std::vector<std::string> notes = notes_that_fit(scale.notes, panel.height() - top);
  const std::uint32_t below = kEdge + kLine * (static_cast<std::uint32_t>(notes.size()) + 1);
  const std::uint32_t height = panel.height() - top - below;
  for (std::uint32_t y = 0; y < height; ++y) {
    const double position = 1 - static_cast<double>(y) / (height - 1);
    panel.fill(kBarLeft, top + y, kBarWidth, 1, scale.colour(position));
  }
  draw_numbers(panel, scale, top, height, ink);
  std::uint32_t line = top + height;
  for (const std::string& note : notes) panel.text(kBarLeft, line += kLine, note, ink);
  return rgb;
}

}  // namespace sightline::client::cli::picture
