// Powers of two, so that nothing but the rounding of a coordinate is inexact.
#include "client/importer/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "client/importer/finite.h"

namespace sightline::client::importer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kQuantum = 0x1p-24;       // steps
constexpr double kReach = 0x1p-12;         // share of the distance from zero: most meshes' step
constexpr double kLarger = 0x1p4;          // times the step, for meshes that do not fit it
constexpr double kSmaller = 0x1p-3;        // times the step, for meshes that it is too coarse for
constexpr double kChosenLoss = 1e-4;       // share of a mesh's size that a step may lose
constexpr double kLeastReach = 0x1p-1000;  // floats do not tell such coordinates from zero

}  // namespace

VertexBox::VertexBox()
    : lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity} {}

void VertexBox::add(const Point& vertex) {
  if (!is_finite(vertex)) return;
  for (std::size_t k = 0; k < 3; ++k) {
    lo[k] = std::min(lo[k], vertex[k]);
    hi[k] = std::max(hi[k], vertex[k]);
  }
}

void VertexBox::add(const VertexBox& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    lo[k] = std::min(lo[k], other.lo[k]);
    hi[k] = std::max(hi[k], other.hi[k]);
  }
}

double VertexBox::size() const { return std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}); }

Point VertexBox::reach() const {
  Point reach{};
  for (std::size_t k = 0; k < 3; ++k) reach[k] = std::max(std::abs(lo[k]), std::abs(hi[k]));
  return reach;
}

VertexBox box_of(const FileMesh& mesh) {
  std::vector<char> is_named(mesh.vertices.size(), mesh.faces.corners.empty() ? 1 : 0);
  for (const std::uint32_t vertex : mesh.faces.corners) is_named[vertex] = 1;
  VertexBox box;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (is_named[v] != 0) box.add(mesh.vertices[v]);
  }
  return box;
}

LatticeStep::LatticeStep() : step_(kInfinity) {}

LatticeStep::LatticeStep(double size, const Point& reach) : LatticeStep() {
  const double farthest = *std::max_element(reach.begin(), reach.end());
  if (!(size > 0) || !(size < kInfinity) || !(farthest > kLeastReach)) return;
  int exponent = 0;
  std::frexp(farthest, &exponent);
  const int above = exponent + (4 - exponent % 4) % 4;  // a multiple of 4
  step_ = std::ldexp(kReach, above);
  while (step_ < size) step_ *= kLarger;
  while (error(reach) > kChosenLoss * size) step_ *= kSmaller;
}

double LatticeStep::error(const Point& reach) const {
  double largest = 0;
  for (const double r : reach) {
    const bool is_far = std::abs(r) >= kFarSteps * step_;
    largest = std::max(largest, is_far ? step_ / 2 : std::abs(r));
  }
  return largest * kQuantum;
}

double LatticeStep::rounded(double coordinate) const {
  if (!(std::abs(coordinate) >= kFarSteps * step_))
    return static_cast<double>(static_cast<float>(coordinate));
  const double quantum = step_ * kQuantum;
  if (std::abs(coordinate) >= 0x1p53 * quantum) return coordinate;  // a multiple already
  return std::nearbyint(coordinate / quantum) * quantum;
}

Point LatticeStep::offset(const VertexBox& box) const {
  const Point reach = box.reach();
  Point offset{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (reach[k] < kFarSteps * step_) continue;
    offset[k] = std::nearbyint((box.lo[k] / 2 + box.hi[k] / 2) / step_) * step_;
  }
  return offset;
}

}  // namespace sightline::client::importer
