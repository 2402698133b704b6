// Light and colour.
#include "client/cli/picture/shading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sightline::client::cli::picture {
namespace {

Rgb times(const Rgb& colour, double factor) {
  const auto f = static_cast<float>(factor);
  return {colour[0] * f, colour[1] * f, colour[2] * f};
}

// The value that `part` of the values lie below; 0 if there are none.
double quantile(std::vector<float>& values, double part) {
  if (values.empty()) return 0;
  const std::ptrdiff_t place = std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(place)]);
}

std::vector<float> values_of_hits(const std::vector<Sample>& samples) {
  std::vector<float> values;
  for (const Sample& sample : samples) {
    if (sample.light >= 0) values.push_back(sample.value);
  }
  return values;
}

}  // namespace

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

Rgb normal_shade(const Vec3& normal, const Camera& camera, UpAxis up) {
  const Vec3 n = up == UpAxis::kZ ? Vec3{normal[0], normal[2], -normal[1]} : normal;
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

Rgb backdrop(double y) {
  static const Rgb kTop = from_oklch(0.97, 0.006, 250);
  static const Rgb kBottom = from_oklch(0.86, 0.012, 260);
  const auto s = static_cast<float>(y);
  return {std::lerp(kTop[0], kBottom[0], s), std::lerp(kTop[1], kBottom[1], s),
          std::lerp(kTop[2], kBottom[2], s)};
}

std::vector<Rgb> depth_shades(const std::vector<Sample>& samples) {
  std::vector<float> values = values_of_hits(samples);
  const double near = quantile(values, 0.01);
  const double far = quantile(values, 0.99);
  const double range = far > near ? far - near : 1;
  const Rgb behind = from_oklch(0.13, 0.02, 285);
  std::vector<Rgb> colours;
  colours.reserve(samples.size());
  for (const Sample& sample : samples) {
    const double s = (static_cast<double>(sample.value) - near) / range;
    colours.push_back(sample.light < 0
                          ? behind
                          : times(depth_colour(s), 0.7 + 0.3 * static_cast<double>(sample.light)));
  }
  return colours;
}

std::vector<Rgb> heat_shades(const std::vector<Sample>& samples) {
  constexpr double kUnbuiltLight = 0.2;
  std::vector<float> values = values_of_hits(samples);
  const double most = std::max(quantile(values, 0.995), 1.0);
  std::vector<Rgb> colours;
  colours.reserve(samples.size());
  for (const Sample& sample : samples) {
    const Rgb heat = heat_colour(std::sqrt(static_cast<double>(sample.value) / most));
    const double light = sample.light >= 0 ? 0.45 + 0.55 * static_cast<double>(sample.light)
                         : sample.unbuilt  ? kUnbuiltLight
                                           : 0.6;
    colours.push_back(times(heat, light));
  }
  return colours;
}

}  // namespace sightline::client::cli::picture
