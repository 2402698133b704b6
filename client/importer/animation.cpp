// Finds the two keys around a time, and interpolates between them.
#include "client/importer/animation.h"

#include <algorithm>
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

Quaternion normalized(Quaternion q) {
  double square = 0;
  for (const double x : q) square += x * x;
  for (double& x : q) x /= std::sqrt(square);
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

template <class Value>
Value between(const Key<Value>& a, const Key<Value>& b, double seconds) {
  const double length = b.seconds - a.seconds;
  return length > 0 ? mix(a.value, b.value, (seconds - a.seconds) / length) : b.value;
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
    return is_before ? keys.front().value : keys.back().value;
  }
  const auto later = std::upper_bound(keys.begin(), keys.end(), seconds,
                                      [](double t, const Key<Value>& k) { return t < k.seconds; });
  if (keys.size() == 1) return keys.front().value;
  const auto b = std::clamp(later, keys.begin() + 1, keys.end() - 1);
  return between(*(b - 1), *b, seconds);
}

template Point sample(const Track<Point>&, double);
template Quaternion sample(const Track<Quaternion>&, double);
template std::vector<double> sample(const Track<std::vector<double>>&, double);

}  // namespace sightline::client::importer
