// Numbers in the bytes of files, in the types of NumPy and PLY.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace sightline::client::cli::files {

struct ScalarType {
  std::size_t bytes = 0;
  bool is_float32 = false;
  /// The number at an address, which may have any alignment.
  double (*load)(const std::byte* at) = nullptr;
};

/// The type of a NumPy dtype such as <f8, >i2 or |b1. Nothing for complex, long double, objects,
/// texts, dates and structures.
std::optional<ScalarType> scalar_of_npy(std::string_view dtype);

/// The type of a PLY property such as float or uint8.
std::optional<ScalarType> scalar_of_ply(std::string_view name, bool big_endian);

}  // namespace sightline::client::cli::files
