// The meshes on which methods fail, by name.
#include "tests/support/hard_meshes.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/find_named.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {

namespace {

constexpr std::array<std::string_view, kBounds> kBoundNames{"references", "depth", "touches",
                                                            "work", "cells given up"};

TestMesh far_ball(std::uint32_t triangles, double distance, std::uint64_t seed) {
  return ball(triangles, {distance, distance, distance}, 100, 0.3, seed);
}

std::vector<HardMesh> make_table() {
  using N = std::uint32_t;
  using Seed = std::uint64_t;
  return {
      {"compact", "-", "hills: none of what follows", hills},
      {"wall", "F1", "half of the triangles in one plane: a step in the counts",
       [](N n, Seed s) { return walls_among_scattered(n, 1, s); }},
      {"two-walls", "F1", "a quarter in each of two planes: a hat",
       [](N n, Seed s) { return walls_among_scattered(n, 2, s); }},
      {"stadium", "F2", "nine tenths in a millionth of the volume", ball_in_stadium},
      {"nested", "F3", "ten balls, each a thousandth of the one before", nested_balls},
      {"slivers", "F4", "long needles turned every way", slivers},
      {"sheet", "F5 F23", "one plane, no extent across it", [](N n, Seed) { return sheet(n); }},
      {"cube", "F5 F22", "all triangles in the faces of the box",
       [](N n, Seed) { return tiled_cube(n); }},
      {"rooms", "F6 F22", "walls between the cells of a lattice", rooms},
      {"duplicates", "F7", "one triangle, again and again",
       [](N n, Seed) { return duplicates(n); }},
      {"stacks", "F7", "every triangle a hundred times", stacked_hills},
      {.name = "fan",
       .rows = "F8",
       .what = "all share a vertex",
       .make = fan_about_vertex,
       .references = 4},
      {.name = "book",
       .rows = "F8",
       .what = "all share a long edge",
       .make = pages_of_book,
       .references = 4},
      {"rods", "F9", "parallel needles through the whole box, tilted", tilted_rods},
      {"interleaved", "F10", "floor and object in turns, in step with sub-sampling", interleaved},
      {"furnished", "F11", "sixteen boxes a room: no first cut pays",
       [](N n, Seed) { return furnished_rooms(n); }},
      {"shell", "F12", "a ball with a rough surface",
       [](N n, Seed s) {
         return ball(n, {0, 0, 0}, 1, 1, s);
       }},
      {"halving", "F13", "sixty cubes in a corner, each half as wide as the one before",
       halving_staircase},
      {"turned-halls", "F14", "walls and columns, turned by 45 degrees about every axis",
       [](N n, Seed) { return turned_halls(n); }},
      {"far-1e5", "F16", "200 wide, 1e5 from the origin in float",
       [](N n, Seed s) { return far_ball(n, 1e5, s); }},
      {"far-1e6", "F16", "the same at 1e6", [](N n, Seed s) { return far_ball(n, 1e6, s); }},
      {"far-1e7", "F16", "the same at 1e7, where floats are a unit apart",
       [](N n, Seed s) { return far_ball(n, 1e7, s); }},
      {"huge-and-tiny", "F17", "a beam of 5.9e11, a kilometre of hills, a ball of a millimetre",
       huge_and_tiny},
      {"denormal", "F18", "edges shorter than the least normal float",
       [](N n, Seed s) {
         return ball(n, {0, 0, 0}, 1e-36, 0.3, s);
       }},
      {"nonfinite", "F19", "NaN and infinite vertices", with_nonfinite},
      {"zero-area", "F20", "one in a hundred a point or a line", with_zero_area},
      {"large-over-small", "F25", "triangles as large as the scene over small ones",
       large_over_small},
  };
}

}  // namespace

std::string_view bound_name(Bound bound) { return kBoundNames[static_cast<std::size_t>(bound)]; }

double HardMesh::allowed(Bound bound) const {
  return std::array{references, depth, touches, work, 0.0}[static_cast<std::size_t>(bound)];
}

double TreeCost::of(Bound bound) const {
  return std::array{references, depth, touches, work,
                    failed_cells}[static_cast<std::size_t>(bound)];
}

const std::vector<HardMesh>& hard_meshes() {
  static const std::vector<HardMesh> kTable = make_table();
  return kTable;
}

const HardMesh* find_hard_mesh(std::string_view name) { return find_named(hard_meshes(), name); }

double levels_beyond_good(int depth, std::uint64_t triangles) {
  const double good = 8 + 1.3 * std::log2(std::max(1.0, static_cast<double>(triangles)));
  return std::max(0.0, depth - good);
}

std::string Breach::text() const {
  return fmt::format("{} {:.3g} over {:.3g}", bound_name(bound), value, allowed);
}

std::vector<Breach> breaches(const HardMesh& mesh, std::string_view builder, const TreeCost& cost) {
  std::vector<Breach> found;
  for (std::size_t i = 0; i < kBounds; ++i) {
    const auto bound = static_cast<Bound>(i);
    const double value = cost.of(bound), allowed = mesh.allowed(bound);
    if (!(value > allowed)) continue;  // Unknown values break no bound
    found.push_back({bound, value, allowed, design_failure(mesh.name, builder, bound)});
  }
  return found;
}

}  // namespace sightline::tests
