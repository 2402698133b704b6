// Shapes at which methods of building and walking trees fail: generators for hard_meshes.h.
#pragma once

#include <cstdint>

#include "tests/support/scenes.h"

namespace sightline::tests {

// Each has at most `triangles` faces, and as many as its parts allow (a furnished room is made of
// 204). Any number will do, 0 among them. They are the same on every machine.

/// Hills over a square, the vertices out of line: what other meshes are held against.
TestMesh hills(std::uint32_t triangles, std::uint64_t seed);

// hard_flats.cpp: flat triangles along the axes.

/// Half of them in `walls` planes across x at positions that are no fraction of the box, the rest
/// scattered through the unit cube.
TestMesh walls_among_scattered(std::uint32_t triangles, std::uint32_t walls, std::uint64_t seed);
/// A square lattice in the plane y = 1/pi, with no extent across it.
TestMesh sheet(std::uint32_t triangles);
/// The six sides of the unit cube, each a lattice.
TestMesh tiled_cube(std::uint32_t triangles);
/// A cube of rooms: of the quads between neighbouring cells of a lattice, an odd number an axis,
/// seven in ten are there.
TestMesh rooms(std::uint32_t triangles, std::uint64_t seed);
/// Rooms with sixteen boxes each, four by four, that stand on the floor: 204 triangles a room.
TestMesh furnished_rooms(std::uint32_t triangles);

// hard_scales.cpp: large and small together, far away, near the least of floats.

/// A tiled ball about `center`; its radius varies by `noise` widths of its triangles.
TestMesh ball(std::uint32_t triangles, const accel::geometry::Vec3d& center, double radius,
              double noise, std::uint64_t seed);
/// Nine in ten of them a ball in a millionth of the box, the rest stands around it.
TestMesh ball_in_stadium(std::uint32_t triangles, std::uint64_t seed);
/// Ten balls about one point, each a thousandth of the size of the one before.
TestMesh nested_balls(std::uint32_t triangles, std::uint64_t seed);
/// Triangles scattered in 60 cubes, each with a corner at the origin and half as wide as the one
/// before.
TestMesh halving_staircase(std::uint32_t triangles, std::uint64_t seed);
/// A beam of 5.9e11 by 1.2e5, and by its middle hills of a kilometre and a ball of a millimetre.
TestMesh huge_and_tiny(std::uint32_t triangles, std::uint64_t seed);

// hard_overlaps.cpp: boxes that lie over each other.

/// Needles of 1 to 1e-4 in the unit cube, turned every way.
TestMesh slivers(std::uint32_t triangles, std::uint64_t seed);
/// Needles across the unit cube along x, all tilted alike.
TestMesh tilted_rods(std::uint32_t triangles, std::uint64_t seed);
/// Blades about one vertex, up and down in turns.
TestMesh fan_about_vertex(std::uint32_t triangles, std::uint64_t seed);
/// Pages of a book: all share the edge from (0, 0, 0) to (1, 1, 1).
TestMesh pages_of_book(std::uint32_t triangles, std::uint64_t seed);
/// The triangles of hills, a hundredth as many, each a hundred times, apart in the index order.
TestMesh stacked_hills(std::uint32_t triangles, std::uint64_t seed);
/// Halls of columns and walls, turned by 45 degrees about every axis.
TestMesh turned_halls(std::uint32_t triangles);
/// One triangle over every hundred small ones, as large as the whole.
TestMesh large_over_small(std::uint32_t triangles, std::uint64_t seed);

// hard_orders.cpp: what is odd about the arrays.

/// Floor and object in turns: of N faces every floor(log10 N)-th is the floor's.
TestMesh interleaved(std::uint32_t triangles, std::uint64_t seed);
/// A ball of whose vertices one in 500 is NaN or infinite.
TestMesh with_nonfinite(std::uint32_t triangles, std::uint64_t seed);
/// Hills of whose triangles one in a hundred is a point, a line, or has its corners in a line.
TestMesh with_zero_area(std::uint32_t triangles, std::uint64_t seed);

}  // namespace sightline::tests
