// Round numbers as ticks.
#include "client/load/report/axis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sightline::client::load::report {

Axis Axis::linear(double low, double high, Format format) {
  low = std::min(low, 0.0);
  if (!(high > low)) high = low + 1;
  constexpr double kMostTicks = 5;
  const double decade = std::pow(10.0, std::floor(std::log10((high - low) / kMostTicks)));
  double step = 10 * decade;
  for (const double candidate : {5.0, 2.0, 1.0}) {
    if (candidate * decade * kMostTicks >= high - low) step = candidate * decade;
  }
  Axis axis(low, std::ceil(high / step) * step, false);
  for (double k = std::ceil(low / step); k * step <= axis.high_ * (1 + 1e-9); ++k)
    axis.ticks_.push_back({k * step, format(k * step)});
  return axis;
}

Axis Axis::logarithmic(double low, double high, Format format) {
  Axis axis(std::log10(low), std::log10(std::max(high, low * 1.01)), true);
  constexpr double kFewDecades = 2.5, kManyDecades = 7;
  const double decades = axis.high_ - axis.low_;
  const double margin = 0.02 * decades;
  axis.low_ -= margin;
  axis.high_ += margin;
  const int step = decades > kManyDecades ? 2 : 1;
  for (int power = static_cast<int>(std::floor(axis.low_)); power <= axis.high_; power += step) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (digit > 1 && decades > kFewDecades) continue;
      const double value = digit * std::pow(10.0, power);
      if (std::log10(value) >= axis.low_ && std::log10(value) <= axis.high_)
        axis.ticks_.push_back({value, format(value)});
    }
  }
  constexpr std::size_t kFewestTicks = 2;
  return axis.ticks_.size() < kFewestTicks ? linear(0, high, format) : axis;
}

Axis Axis::with_ticks(std::vector<Tick> ticks, double high) {
  Axis axis(ticks.front().value, std::max(high, ticks.front().value + 1e-9), false);
  axis.ticks_ = std::move(ticks);
  std::erase_if(axis.ticks_, [&](const Tick& tick) { return tick.value > axis.high_; });
  return axis;
}

double Axis::position(double value) const {
  const double at = is_log_ ? std::log10(std::max(value, 1e-300)) : value;
  return std::clamp((at - low_) / (high_ - low_), 0.0, 1.0);
}

}  // namespace sightline::client::load::report
