// Rays or points as columns in memory, of any types and strides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/row_layout.h"
#include "client/cli/files/scalar.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// One number a row.
struct TableColumn {
  const std::byte* data = nullptr;  ///< the first row's
  std::uint64_t stride = 0;         ///< bytes from row to row
  ScalarType type;

  double at(std::uint64_t row) const { return type.load(data + row * stride); }
};

struct RayTable {
  /// As in RayRow; the data of those that rows do not have is null.
  std::array<TableColumn, std::tuple_size_v<RayRow>> columns{};
  std::vector<std::uint64_t> shape{};                 ///< the rows' shape, e.g. (height, width)
  std::vector<std::shared_ptr<const void>> owners{};  ///< owners of the data

  std::uint64_t rows() const;
  bool has_interval() const { return columns[7].data != nullptr; }
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
Result<NpyArray> parse_npy_array(std::span<const std::byte> file, RowKind kind = RowKind::kRays);

/// The rays of an array of shape (..., 6) or (..., 8), or the points of one of shape (..., 3) or
/// (..., 4). Errors: kInvalidArgument, another shape.
Result<RayTable> table_of(const NpyArray& rows, RowKind kind = RowKind::kRays);

/// The rays of arrays (..., 3), (..., 3) and, if they are there, (...) and (...). Errors:
/// kInvalidArgument, shapes that do not fit each other.
Result<RayTable> table_of(const NpyArray& origins, const NpyArray& directions, const NpyArray* tmin,
                          const NpyArray* tmax);

/// The points of arrays (..., 3) and, if it is there, (...). Errors: kInvalidArgument, shapes that
/// do not fit each other.
Result<RayTable> table_of_points(const NpyArray& positions, const NpyArray* max);

/// Gives the rows in order. Scalar is float or double.
template <class Scalar>
RaySource<Scalar> source_of(std::shared_ptr<const RayTable> table);

}  // namespace sightline::client::cli::files
