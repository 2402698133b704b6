// Digits in threes, shares, and units.
#include "client/cli/amounts.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>

namespace sightline::client::cli {
namespace {

// What is not all of it never reads as all of it, and what is not nothing never as nothing.
std::string percent(std::uint64_t part, std::uint64_t whole) {
  const double share = 100 * static_cast<double>(part) / static_cast<double>(whole);
  if (part < whole && share > 99.9) return "99.9 %";
  if (part > 0 && share < 0.1) return "below 0.1 %";
  return fmt::format("{:.{}f} %", share, part == whole || part == 0 ? 0 : 1);
}

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t place = text.size(); place > 3;) {
    place -= 3;
    text.insert(place, ",");
  }
  return text;
}

std::string part_of(std::uint64_t part, std::uint64_t whole) {
  std::string text = grouped(part) + " of " + grouped(whole);
  if (whole > 0) text += " (" + percent(part, whole) + ")";
  return text;
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  constexpr std::array<const char*, 4> kUnits{"kB", "MB", "GB", "TB"};
  double amount = static_cast<double>(bytes) / 1000;
  std::size_t unit = 0;
  for (; amount >= 999.95 && unit + 1 < kUnits.size(); ++unit) amount /= 1000;
  return fmt::format("{:.1f} {}", amount, kUnits[unit]);
}

}  // namespace sightline::client::cli
