// Palettes and light. OKLab is by Björn Ottosson; its matrices are part of its definition.
#include "client/cli/picture/shading.h"

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

// Interpolates between stops that are evenly spaced.
Rgb ramp(std::span<const Stop> stops, double s) {
  const double position = std::clamp(s, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(position), stops.size() - 2);
  const double part = position - static_cast<double>(first);
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

// Within sRGB all along.
constexpr std::array<Stop, 5> kClearance{
    {{0.38, 0.14, 22}, {0.51, 0.165, 32}, {0.65, 0.145, 50}, {0.80, 0.125, 75}, {0.95, 0.07, 100}}};

// A fraction of a turn. The golden ratio gives consecutive ids distant hues.
double hue_turn(std::uint64_t id) {
  constexpr double kGolden = 1 / std::numbers::phi;
  const double turns = static_cast<double>(id % 1'000'003) * kGolden;
  return turns - std::floor(turns);
}

Rgb times(const Rgb& colour, double factor) {
  const auto f = static_cast<float>(factor);
  return {colour[0] * f, colour[1] * f, colour[2] * f};
}

// The value that is larger than `part` of the values; 0 if there are none.
double quantile(std::vector<float>& values, double part) {
  if (values.empty()) return 0;
  const std::ptrdiff_t rank = std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(rank)]);
}

std::vector<float> values_of_hits(const std::vector<Sample>& samples) {
  std::vector<float> values;
  for (const Sample& sample : samples) {
    if (sample.light >= 0) values.push_back(sample.value);
  }
  return values;
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

Rgb clearance_colour(double s) { return ramp(kClearance, s); }

Rgb node_colour(std::uint64_t id) {
  constexpr std::array<double, 3> kLightness{0.80, 0.70, 0.62};
  return from_oklch(kLightness[id % kLightness.size()], 0.13, 360 * hue_turn(id));
}

std::uint8_t encode_srgb(float linear) {
  const double x = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

Vec3 facing(const Vec3& normal, const Vec3& direction) {
  return dot(normal, direction) > 0 ? scale(normal, -1) : normal;
}

double light_on(const Vec3& normal, const Camera& camera) {
  const Vec3 key =
      unit(add(scale(camera.forward, -0.7), add(scale(camera.up, 0.8), scale(camera.right, -0.5))));
  const double wrapped = 0.5 + 0.5 * dot(normal, key);
  const double head = std::max(0.0, -dot(normal, camera.forward));
  return std::clamp(0.72 * wrapped * wrapped + 0.28 * head, 0.0, 1.0);
}

Rgb normal_shade(const Vec3& normal, const Camera& camera) {
  const Axes& scene = camera.scene;
  const Vec3 n{dot(normal, scene.side), dot(normal, scene.up), dot(normal, scene.front)};
  const double light = 0.35 + 0.75 * light_on(normal, camera);
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double tint = 0.5 + 0.5 * n[k];
    colour[k] = static_cast<float>(light * std::pow(0.38 + 0.62 * tint, 1.7));
  }
  return colour;
}

Rgb node_shade(std::uint64_t node, const Vec3& normal, const Camera& camera) {
  return times(node_colour(node), 0.3 + 0.8 * light_on(normal, camera));
}

Rgb sun_shade(const Vec3& normal, const Vec3& sun, bool in_shadow, const Camera& camera) {
  static const Rgb kClay = from_oklch(0.9, 0.02, 75);
  constexpr Rgb kSun{0.80F, 0.74F, 0.64F}, kSky{0.20F, 0.24F, 0.30F}, kGround{0.12F, 0.11F, 0.10F};
  constexpr double kLamp = 0.12;
  const auto direct = static_cast<float>(in_shadow ? 0 : std::max(0.0, dot(normal, sun)));
  const auto above = static_cast<float>(0.5 + 0.5 * dot(normal, camera.scene.up));
  const auto lamp = static_cast<float>(kLamp * std::max(0.0, -dot(normal, camera.forward)));
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    const float around = std::lerp(kGround[k], kSky[k], above);
    colour[k] = kClay[k] * (direct * kSun[k] + around + lamp);
  }
  return colour;
}

Rgb backdrop(double y) {
  static const Rgb kTop = from_oklch(0.97, 0.006, 250);
  static const Rgb kBottom = from_oklch(0.86, 0.012, 260);
  const auto s = static_cast<float>(y);
  return {std::lerp(kTop[0], kBottom[0], s), std::lerp(kTop[1], kBottom[1], s),
          std::lerp(kTop[2], kBottom[2], s)};
}

ValueRange depth_range(const std::vector<Sample>& samples) {
  std::vector<float> values = values_of_hits(samples);
  const double near = quantile(values, 0.01);
  const double far = quantile(values, 0.99);
  return {near, far > near ? far : near + 1};
}

ValueRange heat_range(const std::vector<Sample>& samples) {
  std::vector<float> values = values_of_hits(samples);
  return {0, std::max(quantile(values, 0.995), 1.0)};
}

double depth_position(double value, const ValueRange& range) {
  return std::clamp((value - range.low) / (range.high - range.low), 0.0, 1.0);
}

double heat_position(double value, const ValueRange& range) {
  return std::sqrt(depth_position(value, range));
}

std::vector<Rgb> depth_shades(const std::vector<Sample>& samples, const ValueRange& range) {
  const Rgb behind = from_oklch(0.13, 0.02, 285);
  std::vector<Rgb> colours;
  colours.reserve(samples.size());
  for (const Sample& sample : samples) {
    const Rgb colour = depth_colour(depth_position(static_cast<double>(sample.value), range));
    colours.push_back(
        sample.light < 0 ? behind : times(colour, 0.7 + 0.3 * static_cast<double>(sample.light)));
  }
  return colours;
}

Rgb clearance_shade(const Sample& sample, const ValueRange& range) {
  static const Rgb kAlone = from_oklch(0.55, 0, 0);
  const auto distance = static_cast<double>(sample.value);
  const Rgb colour =
      std::isfinite(distance) ? clearance_colour(depth_position(distance, range)) : kAlone;
  return times(colour, 0.7 + 0.3 * static_cast<double>(sample.light));
}

Rgb context_shade(double light) {
  static const Rgb kPlaster = from_oklch(0.88, 0.004, 260);
  return times(kPlaster, 0.6 + 0.4 * light);
}

std::vector<Rgb> heat_shades(const std::vector<Sample>& samples, const ValueRange& range) {
  constexpr double kDeferredLight = 0.2;
  std::vector<Rgb> colours;
  colours.reserve(samples.size());
  for (const Sample& sample : samples) {
    const Rgb heat = heat_colour(heat_position(static_cast<double>(sample.value), range));
    const double light = sample.light >= 0 ? 0.45 + 0.55 * static_cast<double>(sample.light)
                         : sample.deferred ? kDeferredLight
                                           : 0.6;
    colours.push_back(times(heat, light));
  }
  return colours;
}

}  // namespace sightline::client::cli::picture
