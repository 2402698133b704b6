// Formats numbers for people.
#include "client/load/report/text.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace sightline::client::load::report {
namespace {

// Three significant digits, without zeros behind the point that say nothing.
std::string digits(double value) {
  const double size = std::abs(value);
  const int decimals = size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2;
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (decimals > 0) {
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  return text;
}

template <std::size_t n>
std::string with_unit(double value, const std::array<const char*, n>& units) {
  std::size_t unit = 0;
  while (std::abs(value) >= 999.5 && unit + 1 < n) {
    value /= 1000;
    ++unit;
  }
  const std::string text = digits(value);
  return *units.at(unit) == '\0' ? text : text + " " + units.at(unit);
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string short_number(double value) {
  return with_unit(value, std::array{"", "k", "M", "G", "T"});
}

std::string duration(double seconds) {
  if (seconds == 0) return "0";
  if (seconds >= 1) return digits(seconds) + " s";
  return with_unit(seconds * 1e9, std::array{"ns", "µs", "ms", "s"});
}

std::string bytes(double count) {
  return with_unit(count, std::array{"B", "kB", "MB", "GB", "TB"});
}

std::string percent(double share) {
  const double value = share * 100;
  return fmt::format("{:.{}f} %", value, value != 0 && std::abs(value) < 9.95 ? 1 : 0);
}

}  // namespace sightline::client::load::report
