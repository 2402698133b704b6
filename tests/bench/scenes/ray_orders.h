// The same rays in another order.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"

namespace sightline::bench {

/// as-made, reversed, shuffled, by-origin, strided.
std::vector<std::string_view> ray_order_names();

/// The indices of the rays in that order. `name` is one of ray_order_names().
std::vector<std::size_t> ray_order(std::string_view name,
                                   std::span<const accel::geometry::Ray> rays);

}  // namespace sightline::bench
