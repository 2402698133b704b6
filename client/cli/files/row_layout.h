// What a row of a file is: a ray, or a point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace sightline::client::cli::files {

enum class RowKind : std::uint8_t { kRays, kPoints };

/// The numbers of a ray: origin, direction, tmin and tmax. A point has an origin, and its greatest
/// distance as tmax.
using RayRow = std::array<double, 8>;

/// The numbers of a row as a file has them.
struct RowLayout {
  std::string_view row, rows;  ///< "ray" and "rays"
  /// In the order of a file without a line of names.
  std::span<const std::string_view> names;
  std::span<const std::size_t> columns;  ///< for each name its index in RayRow
  std::size_t required = 0;              ///< of these, the first, every file has this number
  /// Names of three numbers together, each with the first of them.
  std::span<const std::pair<std::string_view, std::size_t>> vectors;
};

const RowLayout& layout_of(RowKind kind);

}  // namespace sightline::client::cli::files
