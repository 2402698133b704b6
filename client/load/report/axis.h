// From values to positions along an axis, and the marks that name values.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sightline::client::load::report {

using Format = std::string (*)(double);

struct Tick {
  double value = 0;
  std::string label;
};

class Axis {
 public:
  /// A linear axis begins at 0 if `low` is not below; a logarithmic one needs values above 0,
  /// and becomes linear if no two round numbers are among them.
  static Axis linear(double low, double high, Format format);
  static Axis logarithmic(double low, double high, Format format);
  /// A linear axis from the first of these ticks to `high`.
  static Axis with_ticks(std::vector<Tick> ticks, double high);

  /// 0 at the beginning of the axis, 1 at its end, and within that for values beyond.
  double position(double value) const;
  const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  Axis(double low, double high, bool is_log) : low_(low), high_(high), is_log_(is_log) {}

  double low_;  // values, or their logarithms
  double high_;
  bool is_log_;
  std::vector<Tick> ticks_;
};

}  // namespace sightline::client::load::report
