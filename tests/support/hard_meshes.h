// The meshes on which methods fail, by name: a description, the allowed costs of a good tree, and
// the methods that cost more by design.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/scenes.h"

namespace sightline::tests {

/// The bounded costs of a tree.
enum class Bound : std::uint8_t {
  kReferences,  ///< References in leaves, a triangle.
  kDepth,       ///< Levels beyond 8 + 1.3 log2 n, the depth of a good tree over n triangles.
  kTouches,     ///< Touches of building, a triangle, over those of a compact mesh of the same size.
  kWork,  ///< Steps plus one and a half times tests, a ray, over those of the exact sweep's tree.
  kFailedCells,  ///< Cells that failed for lack of capacity; none is allowed.
};
inline constexpr std::size_t kBounds = 5;
std::string_view bound_name(Bound bound);

struct HardMesh {
  std::string_view name;
  std::string_view rows;  ///< Rows of the catalogue in docs/robustness.md.
  std::string_view what;
  TestMesh (*make)(std::uint32_t triangles, std::uint64_t seed);
  double references = 16, depth = 22, touches = 5,
         work = 2;  ///< The largest allowed values, see Bound.

  double allowed(Bound bound) const;
};

/// In the order of the catalogue.
const std::vector<HardMesh>& hard_meshes();
/// Null if there is no mesh of that name.
const HardMesh* find_hard_mesh(std::string_view name);

/// Why a method of the literature must exceed a bound on a mesh; empty: it must not.
std::string_view design_failure(std::string_view mesh, std::string_view builder, Bound bound);

/// The costs of a tree over a hard mesh, in the units of Bound; NaN if unknown.
struct TreeCost {
  double references = kUnknown, depth = kUnknown, touches = kUnknown, work = kUnknown,
         failed_cells = kUnknown;

  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double of(Bound bound) const;
};

/// Levels beyond 8 + 1.3 log2 n, at least 0.
double levels_beyond_good(int depth, std::uint64_t triangles);

/// An exceeded bound.
struct Breach {
  Bound bound;
  double value, allowed;
  std::string_view by_design;  ///< Why the method must exceed it; empty: it should not.

  std::string text() const;
};
std::vector<Breach> breaches(const HardMesh& mesh, std::string_view builder, const TreeCost& cost);

}  // namespace sightline::tests
