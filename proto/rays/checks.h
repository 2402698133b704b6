// Checks that generators of rays and grids of points share.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "proto/rays/generator.h"

namespace sightline::proto::rays {

using Found = std::optional<Problem>;

inline Found check_numbers(std::string_view name, std::span<const double> numbers) {
  for (const double number : numbers) {
    if (!std::isfinite(number))
      return Problem{fmt::format("{} holds {}, which is not finite", name, number), "NOT_FINITE"};
  }
  return {};
}

inline Found check_side(std::string_view name, std::uint32_t side) {
  if (side >= 1 && side <= kMaxSide) return {};
  return Problem{fmt::format("{} is {}, not from 1 to {}", name, side, kMaxSide), "BAD_SIZE"};
}

}  // namespace sightline::proto::rays
