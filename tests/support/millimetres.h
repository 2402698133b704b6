// A plate of millimeter ridges, seen from a kilometer away: it must look the same at any position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// A square of one meter around the origin, z up, with 1000 ridges along y, each 1 mm wide and 1 mm
/// high, in 20 pieces: 80,000 triangles.
TestMesh ridged_plate();

/// Rays from points one kilometer away, at least 30 degrees above the plate's plane, toward points
/// of the plate at least 5 cm from its border; directions have length 1, so t is in meters. `bits`:
/// origins are multiples of 2^-bits.
std::vector<accel::geometry::Ray> kilometre_rays(std::size_t count, std::uint64_t seed, int bits);

/// For each ray, the ray and four copies with origins moved by `distance` in both directions along
/// x and y: groups of five, the unmoved ray first.
std::vector<accel::geometry::Ray> with_nudges(std::span<const accel::geometry::Ray> rays,
                                              double distance);

/// Compares answers to with_nudges at the origin with those elsewhere. A ray is steady if it and
/// its four copies hit the same primitive at the origin.
struct Displacement {
  std::size_t rays = 0;
  std::size_t steady = 0;
  std::size_t missed = 0;      ///< Rays without a hit, at either position, steady or not.
  std::size_t others = 0;      ///< Steady rays that hit another primitive there.
  double largest_t_error = 0;  ///< Over the steady rays.

  std::string report() const;
};
Displacement displacement(std::span<const accel::geometry::Hit> at_origin,
                          std::span<const accel::geometry::Hit> elsewhere);

}  // namespace sightline::tests
