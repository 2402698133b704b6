// Subtracts the offset from vertices and adds it to transforms.
//
// Why no vertex is rounded: let v be a coordinate on an axis with offset c. v is at most half an
// extent away from the middle, and c at most half a step, so |v - c| is at most one step. |v| is at
// least kFar steps. So c/2 <= v <= 2c, and the difference of two such numbers is exact in double
// (Sterbenz). The difference is a multiple of the last bit of v or of the step, whichever is
// smaller. In the first case it has fewer bits than v; in the second it is a step or zero. In both
// cases it is a float.
#include "client/importer/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace sightline::client::importer {
namespace {

using Offset = std::array<double, 3>;

struct Bounds {
  std::array<double, 3> lo, hi;  // of finite vertices; lo > hi if there is none

  double extent() const { return std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}); }
};

bool is_finite(const Point& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

Bounds bounds_of(const std::vector<FileMesh>& meshes) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Bounds bounds{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const FileMesh& mesh : meshes) {
    for (const Point& v : mesh.vertices) {
      if (!is_finite(v)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        bounds.lo[k] = std::min(bounds.lo[k], v[k]);
        bounds.hi[k] = std::max(bounds.hi[k], v[k]);
      }
    }
  }
  return bounds;
}

Offset offset_for(const Bounds& bounds) {
  Offset offset{};
  const double extent = bounds.extent();
  if (!(extent > 0)) return offset;
  int exponent = 0;
  std::frexp(extent, &exponent);
  const double step = std::ldexp(1.0, exponent);
  for (std::size_t k = 0; k < 3; ++k) {
    // Below 0 if 0 is between the bounds
    const double nearest = std::max(bounds.lo[k], -bounds.hi[k]);
    if (nearest < kFar * step) continue;
    const double middle = bounds.lo[k] + (bounds.hi[k] - bounds.lo[k]) / 2;
    offset[k] = std::round(middle / step) * step;
  }
  return offset;
}

// Returns nothing if the result needs rounding. The same holds for exact_product and `moved`.
std::optional<double> exact_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  const double lost = (a - (sum - of_b)) + (b - of_b);
  if (lost == 0) return sum;
  return std::nullopt;
}

std::optional<double> exact_product(double a, double b) {
  const double product = a * b;
  if (std::fma(a, b, -product) == 0) return product;
  return std::nullopt;
}

// `rows` after a translation by the offset.
std::optional<std::array<double, 12>> moved(std::array<double, 12> rows, const Offset& offset) {
  for (std::size_t r = 0; r < 3; ++r) {
    double& translation = rows[4 * r + 3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto part = exact_product(rows[4 * r + k], offset[k]);
      const auto sum = part ? exact_sum(translation, *part) : std::nullopt;
      if (!sum) return std::nullopt;
      translation = *sum;
    }
  }
  return rows;
}

// The nodes with the offset added, or nothing if some node cannot hold it exactly.
std::optional<std::vector<ImportedNode>> moved(std::vector<ImportedNode> nodes,
                                               const Offset& offset) {
  for (const ImportedNode& node : nodes) {
    if (node.parent != kNone && nodes[node.parent].mesh != kNone) return std::nullopt;
  }
  for (ImportedNode& node : nodes) {
    if (node.mesh == kNone) continue;
    const auto rows = moved(node.parent_from_local, offset);
    if (!rows) return std::nullopt;
    node.parent_from_local = *rows;
  }
  return nodes;
}

void subtract(const Offset& offset, Point& v) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (offset[k] != 0) v[k] -= offset[k];
  }
}

// Whether `subtract` loses nothing.
bool is_exact(const Offset& offset, const Point& v) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto difference = exact_sum(v[k], -offset[k]);
    if (!difference || static_cast<double>(static_cast<float>(*difference)) != *difference)
      return false;
  }
  return true;
}

bool is_exact(const Offset& offset, const std::vector<FileMesh>& meshes) {
  for (const FileMesh& mesh : meshes) {
    for (const Point& v : mesh.vertices) {
      if (is_finite(v) && !is_exact(offset, v)) return false;
    }
  }
  return true;
}

}  // namespace

bool shift(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes, const Offset& offset) {
  if (offset == Offset{}) return true;
  if (!is_exact(offset, meshes)) return false;
  auto with_offset = moved(nodes, offset);
  if (!with_offset) return false;
  nodes = *std::move(with_offset);
  for (FileMesh& mesh : meshes) {
    for (Point& v : mesh.vertices) {
      if (is_finite(v)) subtract(offset, v);
    }
  }
  return true;
}

Offset rebase(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes) {
  const Offset offset = offset_for(bounds_of(meshes));
  return shift(meshes, nodes, offset) ? offset : Offset{};
}

}  // namespace sightline::client::importer
