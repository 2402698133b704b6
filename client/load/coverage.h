// Which part of a scene rays go to.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace sightline::client::load {

/// The numbers, in rising order, of the points nearest to `center`: this share (above 0, up to 1)
/// of them, at least one. So the rays to these points touch one connected part of the scene, and
/// about that share of what rays to all points touch.
std::vector<std::size_t> nearest(std::span<const std::array<double, 3>> points,
                                 const std::array<double, 3>& center, double share);

}  // namespace sightline::client::load
