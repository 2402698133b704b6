// Decodes the points of a request.
#pragma once

#include <cstddef>

#include "accel/geometry/ray_columns.h"
#include "proto/rays/point_grid.h"
#include "proto/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// The number of points, by the lengths of the columns alone. Errors: as count_rays().
Result<std::size_t> count_points(const v1::Points& columns);

/// A view of `count` points from `first` on, as the origins of rays. count_points() has accepted
/// the columns, which must outlive the view, and these points are theirs.
accel::geometry::RayColumns view_points(const v1::Points& columns, std::size_t first,
                                        std::size_t count);

/// Points as the origins of rays, whose directions are valid.
accel::geometry::RayColumns rays_of_points(const void* positions, bool float64, std::size_t count);

/// A checked grid, of any number of points. Errors: kInvalidArgument, naming the field, its value
/// and the limit.
Result<proto::rays::PointGrid> decode_grid(const v1::PointGrid& message);

}  // namespace sightline::server::queries
