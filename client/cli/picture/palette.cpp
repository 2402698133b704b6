// Ramps and hues. OKLab is Björn Ottosson's; its matrices are part of its definition.
#include "client/cli/picture/palette.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace sightline::client::cli::picture {
namespace {

std::array<double, 3> linear_srgb(double lightness, double a, double b) {
  const auto cube = [](double x) { return x * x * x; };
  const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

struct Stop {
  double lightness, chroma, hue;
};

// Between stops that are evenly spaced.
Rgb ramp(std::span<const Stop> stops, double s) {
  const double place = std::clamp(s, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  const double part = place - static_cast<double>(first);
  const Stop& a = stops[first];
  const Stop& b = stops[first + 1];
  return from_oklch(std::lerp(a.lightness, b.lightness, part), std::lerp(a.chroma, b.chroma, part),
                    std::lerp(a.hue, b.hue, part));
}

constexpr std::array<Stop, 6> kHeat{{{0.10, 0.02, 285},
                                     {0.28, 0.12, 295},
                                     {0.45, 0.18, 340},
                                     {0.62, 0.20, 390},
                                     {0.80, 0.17, 430},
                                     {0.97, 0.10, 465}}};
constexpr std::array<Stop, 5> kDepth{
    {{0.95, 0.05, 95}, {0.80, 0.10, 150}, {0.62, 0.10, 205}, {0.44, 0.11, 255}, {0.26, 0.10, 285}}};

// A fraction of a turn that spreads consecutive ids: the golden ratio's.
double hue_turn(std::uint64_t id) {
  constexpr double kGolden = 1 / std::numbers::phi;
  const double turns = static_cast<double>(id % 1'000'003) * kGolden;
  return turns - std::floor(turns);
}

}  // namespace

Rgb from_oklch(double lightness, double chroma, double hue) {
  const double angle = hue * std::numbers::pi / 180;
  std::array<double, 3> rgb{};
  for (int step = 0; step <= 20; ++step) {
    const double c = chroma * (1 - step / 20.0);
    rgb = linear_srgb(lightness, c * std::cos(angle), c * std::sin(angle));
    const auto [low, high] = std::minmax({rgb[0], rgb[1], rgb[2]});
    if (low >= -1e-4 && high <= 1 + 1e-4) break;
  }
  const auto clamp = [](double x) { return static_cast<float>(std::clamp(x, 0.0, 1.0)); };
  return {clamp(rgb[0]), clamp(rgb[1]), clamp(rgb[2])};
}

Rgb heat_colour(double s) { return ramp(kHeat, s); }

Rgb depth_colour(double s) { return ramp(kDepth, s); }

Rgb node_colour(std::uint64_t id) {
  constexpr std::array<double, 3> kLightness{0.80, 0.70, 0.62};
  return from_oklch(kLightness[id % kLightness.size()], 0.13, 360 * hue_turn(id));
}

std::uint8_t encode_srgb(float linear) {
  const double x = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

}  // namespace sightline::client::cli::picture
