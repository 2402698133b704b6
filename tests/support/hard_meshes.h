// The meshes at which methods fail, by name: what each is, what a good tree over it may cost, and
// which methods cost more by design.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/scenes.h"

namespace sightline::tests {

/// What is bounded of a tree.
enum class Bound : std::uint8_t {
  kReferences,  ///< In leaves, a triangle.
  kDepth,       ///< Levels beyond 8 + 1.3 log2 n, the depth of a good tree over n triangles.
  kTouches,     ///< Of building, a triangle, over those of a compact mesh as large.
  kWork,        ///< Steps and one and a half tests, a ray, over those of the exact sweep's tree.
  kGivenUp,     ///< Cells that are never finished for want of room; none is allowed.
};
inline constexpr std::size_t kBounds = 5;
std::string_view bound_name(Bound bound);

struct HardMesh {
  std::string_view name;
  std::string_view rows;  ///< Of the catalogue in docs/robustness.md.
  std::string_view what;
  TestMesh (*make)(std::uint32_t triangles, std::uint64_t seed);
  double references = 16, depth = 22, touches = 5, work = 2;  ///< The most allowed, see Bound.

  double allowed(Bound bound) const;
};

/// In the order of the catalogue.
const std::vector<HardMesh>& hard_meshes();
/// Null: there is none of that name.
const HardMesh* find_hard_mesh(std::string_view name);

/// Why a method of the literature must go beyond a bound on a mesh; empty: it must not.
std::string_view design_failure(std::string_view mesh, std::string_view builder, Bound bound);

/// What a tree over a hard mesh has come to, in the units of Bound; NaN where it is not known.
struct TreeCost {
  double references = kUnknown, depth = kUnknown, touches = kUnknown, work = kUnknown,
         failed = kUnknown;

  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double of(Bound bound) const;
};

/// Levels beyond 8 + 1.3 log2 n, at least 0.
double levels_beyond_good(int depth, std::uint64_t triangles);

/// A bound that was not kept.
struct Breach {
  Bound bound;
  double value, allowed;
  std::string_view by_design;  ///< Why, where the method must fail; empty: it should not have.

  std::string text() const;
};
std::vector<Breach> breaches(const HardMesh& mesh, std::string_view builder, const TreeCost& cost);

}  // namespace sightline::tests
