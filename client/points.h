// Points whose nearest faces are asked for, and points that the server makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "client/cast_options.h"
#include "client/result.h"
#include "proto/rays/point_grid.h"

namespace sightline::client {

using proto::rays::PointGrid;

/// Which optional columns the points of a stream have.
struct PointShape {
  bool max_distance = false;
  bool masks = false;
};

/// Points as columns of arrays, one row per point. Scalar is `float` or `double`, const for
/// reading.
template <class Scalar>
struct PointColumns {
  using Value = Scalar;
  using Shape = PointShape;
  using Mask = std::conditional_t<std::is_const_v<Scalar>, const std::uint32_t, std::uint32_t>;

  std::span<Scalar> positions;  ///< (n, 3)
  /// (n), or empty: +inf for all points. A face at exactly this distance counts; none does below 0
  std::span<Scalar> max_distance{};
  std::span<Mask> masks{};  ///< (n), or empty: all bits set for all points

  std::size_t size() const { return positions.size() / 3; }
};

template <class Scalar>
using PointSource = RowSource<PointColumns<Scalar>>;

/// The positions (n, 3) of the points that a query of the grid asks for, bit by bit. Errors:
/// kInvalidArgument, naming the field, its value and the limit.
Result<std::vector<double>> make_points(const PointGrid& grid);

}  // namespace sightline::client
