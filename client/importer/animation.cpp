// Finds the two keys around a time, and interpolates between them.
#include "client/importer/animation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sightline::client::importer {
namespace {

// Above this cosine the arc is too short to divide by its sine.
constexpr double kNearlyEqual = 1 - 1e-12;

Point mix(const Point& a, const Point& b, double part) {
  Point out{};
  for (std::size_t k = 0; k < 3; ++k) out[k] = a[k] + (b[k] - a[k]) * part;
  return out;
}

double length(const Quaternion& q) {
  double square = 0;
  for (const double x : q) square += x * x;
  return std::sqrt(square);
}

Quaternion normalized(Quaternion q) {
  const double old = length(q);
  for (double& x : q) x /= old;
  return q;
}

Quaternion mix(const Quaternion& a, const Quaternion& b, double part) {
  double cosine = 0;
  for (std::size_t k = 0; k < 4; ++k) cosine += a[k] * b[k];
  const double sign = cosine < 0 ? -1 : 1;  // q and -q are the same rotation
  cosine = std::abs(cosine);
  double of_a = 1 - part;
  double of_b = part;
  if (cosine < kNearlyEqual) {
    const double angle = std::acos(cosine);
    of_a = std::sin((1 - part) * angle) / std::sin(angle);
    of_b = std::sin(part * angle) / std::sin(angle);
  }
  Quaternion out{};
  for (std::size_t k = 0; k < 4; ++k) out[k] = of_a * a[k] + sign * of_b * b[k];
  return normalized(out);
}

std::vector<double> mix(const std::vector<double>& a, const std::vector<double>& b, double part) {
  const auto at = [](const std::vector<double>& v, std::size_t k) {
    return k < v.size() ? v[k] : 0.0;
  };
  std::vector<double> out(std::max(a.size(), b.size()));
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = at(a, k) + (at(b, k) - at(a, k)) * part;
  return out;
}

// Maps a time into the range from the first key to the last, by whole periods.
double folded(double seconds, double first, double last) {
  if (!(last > first)) return first;
  const double turns = std::floor((seconds - first) / (last - first));
  return std::clamp(seconds - turns * (last - first), first, last);
}

// The sum of four values with these weights. An absent weight is 0.
Point combined(const std::array<const Point*, 4>& values, const std::array<double, 4>& weights) {
  Point out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 3; ++k) out[k] += weights[i] * (*values[i])[k];
  }
  return out;
}

Quaternion combined(const std::array<const Quaternion*, 4>& values,
                    const std::array<double, 4>& weights) {
  Quaternion out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) out[k] += weights[i] * (*values[i])[k];
  }
  return out;
}

std::vector<double> combined(const std::array<const std::vector<double>*, 4>& values,
                             const std::array<double, 4>& weights) {
  std::vector<double> out;
  for (std::size_t i = 0; i < 4; ++i) {
    if (out.size() < values[i]->size()) out.resize(values[i]->size());
    for (std::size_t k = 0; k < values[i]->size(); ++k) out[k] += weights[i] * (*values[i])[k];
  }
  return out;
}

const Point& applied(const Point& value) { return value; }
const std::vector<double>& applied(const std::vector<double>& value) { return value; }

// The rotation of a value. Zeros have no direction: they are no rotation.
Quaternion applied(const Quaternion& value) {
  const double size = length(value);
  return size > 0 && std::isfinite(size) ? normalized(value) : Quaternion{1, 0, 0, 0};
}

template <class Value>
Value at_key(const Track<Value>& track, std::size_t key) {
  const Value& value = track.keys[key].value;
  return track.interpolation == Interpolation::kCubic ? applied(value) : value;
}

template <class Value>
Value between(const Track<Value>& track, std::size_t a, std::size_t b, double seconds) {
  const Key<Value>&from = track.keys[a], &to = track.keys[b];
  const double step = to.seconds - from.seconds;
  if (!(step > 0)) return at_key(track, b);
  const double t = (seconds - from.seconds) / step;
  if (track.interpolation == Interpolation::kStep) return t < 1 ? from.value : to.value;
  if (track.interpolation == Interpolation::kLinear) return mix(from.value, to.value, t);
  const double square = t * t, cube = square * t;
  return applied(combined({&from.value, &track.tangents[a].out, &to.value, &track.tangents[b].in},
                          {2 * cube - 3 * square + 1, step * (cube - 2 * square + t),
                           3 * square - 2 * cube, step * (cube - square)}));
}

}  // namespace

template <class Value>
Value sample(const Track<Value>& track, double seconds) {
  const std::vector<Key<Value>>& keys = track.keys;
  const double first = keys.front().seconds;
  const double last = keys.back().seconds;
  const bool is_before = seconds < first;
  const bool is_outside = is_before || seconds > last;
  const Beyond beyond = is_before ? track.before : track.after;
  if (is_outside && beyond == Beyond::kRepeat) {
    seconds = folded(seconds, first, last);
  } else if (keys.size() == 1 || (is_outside && beyond == Beyond::kHold)) {
    return at_key(track, is_before ? 0 : keys.size() - 1);
  }
  const auto later = std::upper_bound(keys.begin(), keys.end(), seconds,
                                      [](double t, const Key<Value>& k) { return t < k.seconds; });
  if (keys.size() == 1) return at_key(track, 0);
  const auto b = std::clamp(later, keys.begin() + 1, keys.end() - 1);
  const auto next = static_cast<std::size_t>(b - keys.begin());
  return between(track, next - 1, next, seconds);
}

template Point sample(const Track<Point>&, double);
template Quaternion sample(const Track<Quaternion>&, double);
template std::vector<double> sample(const Track<std::vector<double>>&, double);

}  // namespace sightline::client::importer
