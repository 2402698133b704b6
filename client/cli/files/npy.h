// Headers of NumPy's .npy files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/result.h"

namespace sightline::client::cli::files {

inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

struct NpyHeader {
  std::string
      dtype;  ///< as written in the file, without quotes, e.g. <f8; a list for structured types
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::size_t data_offset = 0;  ///< bytes from the start of the file
};

/// Reads the header at the start of a file's bytes, versions 1 to 3.
/// Errors: kInvalidArgument, saying what is wrong with it.
Result<NpyHeader> parse_npy_header(std::span<const std::byte> file);

struct NpyField {
  std::string_view name;
  std::string_view type;  ///< e.g. <f8
};

/// The header of n rows with these fields. Its length is the same for every n.
std::string make_npy_header(std::span<const NpyField> fields, std::uint64_t n);
/// The header of an array of rows of this shape, in C order.
std::string make_npy_header(std::span<const NpyField> fields, std::span<const std::uint64_t> shape);
/// The header of an array of numbers of this type.
std::string make_npy_header(std::string_view type, std::span<const std::uint64_t> shape);

}  // namespace sightline::client::cli::files
