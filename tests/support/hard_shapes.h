// Shapes on which building and walking trees fails: generators for hard_meshes.h.
#pragma once

#include <cstdint>

#include "tests/support/scenes.h"

namespace sightline::tests {

// Each has at most `triangles` faces, as many as its parts allow (a furnished room has 204). Any
// number is valid, including 0. They are the same on every machine.

/// Hills over a square, with irregular vertices: the reference for other meshes.
TestMesh hills(std::uint32_t triangles, std::uint64_t seed);

// hard_flats.cpp: flat axis-aligned triangles.

/// Half of them in `walls` planes across x at positions that are no simple fraction of the box, the
/// rest scattered through the unit cube.
TestMesh walls_among_scattered(std::uint32_t triangles, std::uint32_t walls, std::uint64_t seed);
/// A square lattice in the plane y = 1/pi, without extent in y.
TestMesh sheet(std::uint32_t triangles);
/// The six sides of the unit cube, each a lattice.
TestMesh tiled_cube(std::uint32_t triangles);
/// A cube of rooms: seven in ten of the quads between neighboring cells of a lattice with an odd
/// number of cells along each axis.
TestMesh rooms(std::uint32_t triangles, std::uint64_t seed);
/// Rooms on a grid, each with sixteen boxes, four by four, on the floor: 204 triangles a room.
TestMesh furnished_rooms(std::uint32_t triangles);

// hard_scales.cpp: very different sizes, far from the origin, near the smallest floats.

/// A tessellated ball around `center`; its radius varies by `noise` widths of its triangles.
TestMesh ball(std::uint32_t triangles, const accel::geometry::Vec3d& center, double radius,
              double noise, std::uint64_t seed);
/// Nine tenths of them form a ball in a millionth of the box; the rest stands around it.
TestMesh ball_in_stadium(std::uint32_t triangles, std::uint64_t seed);
/// Ten balls around one point, each a thousandth of the size of the one before.
TestMesh nested_balls(std::uint32_t triangles, std::uint64_t seed);
/// Triangles scattered in 60 cubes, each with a corner at the origin and half as wide as the one
/// before.
TestMesh halving_staircase(std::uint32_t triangles, std::uint64_t seed);
/// A beam of 5.9e11 by 1.2e5, and near its middle hills of a kilometer and a ball of a millimeter.
TestMesh huge_and_tiny(std::uint32_t triangles, std::uint64_t seed);

// hard_overlaps.cpp: overlapping boxes.

/// Needles of 1 by 1e-4 in the unit cube, in random directions.
TestMesh slivers(std::uint32_t triangles, std::uint64_t seed);
/// Needles across the unit cube along x, all with the same tilt.
TestMesh tilted_rods(std::uint32_t triangles, std::uint64_t seed);
/// Blades around one vertex, alternately up and down.
TestMesh fan_about_vertex(std::uint32_t triangles, std::uint64_t seed);
/// Pages of a book: all share the edge from (0, 0, 0) to (1, 1, 1).
TestMesh pages_of_book(std::uint32_t triangles, std::uint64_t seed);
/// The triangles of hills, a hundredth of the number, each a hundred times, distant in the index
/// order.
TestMesh stacked_hills(std::uint32_t triangles, std::uint64_t seed);
/// Halls of columns and walls, rotated by 45 degrees about every axis.
TestMesh turned_halls(std::uint32_t triangles);
/// One triangle as large as the whole for every hundred small ones.
TestMesh large_over_small(std::uint32_t triangles, std::uint64_t seed);

// hard_orders.cpp: unusual arrays.

/// Floor and objects alternate: of N faces every floor(log10 N)-th belongs to the floor.
TestMesh interleaved(std::uint32_t triangles, std::uint64_t seed);
/// A ball in which one vertex in 500 is NaN or infinite.
TestMesh with_nonfinite(std::uint32_t triangles, std::uint64_t seed);
/// Hills in which one triangle in a hundred is a point, a line, or has collinear corners.
TestMesh with_zero_area(std::uint32_t triangles, std::uint64_t seed);

}  // namespace sightline::tests
