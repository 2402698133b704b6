// Generators of rays and of points to messages. Internal to the library.
#pragma once

#include "proto/rays/generator.h"
#include "proto/rays/point_grid.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

/// Sets all of the message.
void encode(const proto::rays::RayGenerator& generator, v1::RayGenerator& message);
void encode(const proto::rays::PointGrid& grid, v1::PointGrid& message);

}  // namespace sightline::client::wire
