// Points in an order in which neighbours follow each other.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry/ray_columns.h"

namespace sightline::scenegraph::query {

/// A batch of points along a Morton curve: those of a packet then take the same way through trees,
/// and begin with what is known of the one before.
struct OrderedPoints {
  /// Reads the origins, tmax and masks of these rays. Parallel in the caller's arena. Throws
  /// std::bad_alloc.
  explicit OrderedPoints(const accel::geometry::RayColumns& points);
  OrderedPoints(const OrderedPoints&) = delete;
  OrderedPoints& operator=(const OrderedPoints&) = delete;

  std::vector<std::uint32_t> order;     ///< The index of each of `columns` in the batch.
  accel::geometry::RayColumns columns;  ///< A view of the ordered points.

 private:
  std::vector<double> positions_, tmax_;
  std::vector<std::uint32_t> masks_;
};

}  // namespace sightline::scenegraph::query
