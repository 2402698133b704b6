// A metre of millimetres, seen from a kilometre off: what must look the same wherever it stands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// A square of one metre about the origin, z up, of 1000 ridges along y, each 1 mm wide and 1 mm
/// high, in 20 pieces: 80,000 triangles.
TestMesh ridged_plate();

/// From points one kilometre off, 30 degrees or more above the plate's plane, toward points of the
/// plate at least 5 cm from its rim; directions are of length 1, so t is in metres. `bits`: origins
/// are multiples of 2^-bits.
std::vector<accel::geometry::Ray> kilometre_rays(std::size_t count, std::uint64_t seed, int bits);

/// The rays, and four more of each, their origins moved by `distance` to and fro along x and y: in
/// fives, each ray first.
std::vector<accel::geometry::Ray> with_nudges(std::span<const accel::geometry::Ray> rays,
                                              double distance);

/// Answers to with_nudges at the origin and elsewhere. A ray is steady if it and its four nudges
/// have hit the same primitive at the origin.
struct Displacement {
  std::size_t rays = 0;
  std::size_t steady = 0;
  std::size_t missed = 0;      ///< Rays without a hit, here or there, steady or not.
  std::size_t others = 0;      ///< Steady ones that hit another primitive there.
  double largest_t_error = 0;  ///< Of steady ones.

  std::string report() const;
};
Displacement displacement(std::span<const accel::geometry::Hit> at_origin,
                          std::span<const accel::geometry::Hit> elsewhere);

}  // namespace sightline::tests
