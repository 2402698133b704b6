// The message for a parameter that is out of range.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sightline::accel::split {

/// A message such as "bins is 1, must lie in 2 to 256"; nothing if the value lies in lo to hi, both
/// included. NaN is always out of range.
template <class T>
std::optional<std::string> out_of_range(std::string_view name, T value, T lo, T hi) {
  if (value >= lo && value <= hi) return std::nullopt;
  return std::string(name) + " is " + std::to_string(value) + ", must lie in " +
         std::to_string(lo) + " to " + std::to_string(hi);
}

}  // namespace sightline::accel::split
