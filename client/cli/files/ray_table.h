// Rays as columns in memory, of any types and strides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/scalar.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// One number a ray.
struct TableColumn {
  const std::byte* data = nullptr;  ///< the first ray's
  std::uint64_t stride = 0;         ///< bytes from ray to ray
  ScalarType type;

  double at(std::uint64_t row) const { return type.load(data + row * stride); }
};

struct RayTable {
  /// ox oy oz dx dy dz tmin tmax; without the last two, their data is null.
  std::array<TableColumn, 8> columns{};
  std::vector<std::uint64_t> shape{};                 ///< the rays' shape, e.g. (height, width)
  std::vector<std::shared_ptr<const void>> owners{};  ///< owners of the data

  std::uint64_t rows() const;
  bool has_interval() const { return columns[6].data != nullptr; }
  bool is_float32() const;
};

/// An array of a .npy file, or of a part of a .npz file, in the bytes of the file.
struct NpyArray {
  std::vector<std::uint64_t> shape;
  ScalarType type;
  const std::byte* data = nullptr;      ///< in C order
  std::shared_ptr<const void> owner{};  ///< owns the data, if it was put into that order
};

/// Errors: kInvalidArgument, saying what is wrong: no .npy, cut off, or a type that is not real.
Result<NpyArray> parse_npy_array(std::span<const std::byte> file);

/// The rays of an array of shape (..., 6) or (..., 8). Errors: kInvalidArgument, another shape.
Result<RayTable> table_of(const NpyArray& rays);

/// The rays of arrays (..., 3), (..., 3) and, if they are there, (...) and (...). Errors:
/// kInvalidArgument, shapes that do not fit each other.
Result<RayTable> table_of(const NpyArray& origins, const NpyArray& directions, const NpyArray* tmin,
                          const NpyArray* tmax);

/// Gives the rays in order. Scalar is float or double.
template <class Scalar>
RaySource<Scalar> source_of(std::shared_ptr<const RayTable> table);

}  // namespace sightline::client::cli::files
