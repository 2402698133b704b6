// Compares answers with the oracle's.
#include "tests/support/compare_hits.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace sightline::tests {
namespace {

constexpr std::size_t kExamples = 10;
constexpr double kSurfaceTolerance = 1e-4;

using accel::geometry::HitState;

bool close_in_t(const accel::geometry::Hit& hit, const Candidate& c) {
  return std::abs(hit.t - c.t) <= c.t_tolerance;
}

bool same_triangle(const accel::geometry::Hit& hit, const Candidate& c) {
  return hit.node == c.node && hit.primitive == c.primitive;
}

bool is_miss(const accel::geometry::Hit& hit) {
  return hit.state == HitState::kMiss && hit.node == 0 && hit.t == accel::geometry::kInfinity;
}

// A hit that some choice among the borderline candidates makes right.
bool edge_explains_hit(const accel::geometry::Hit& hit, const Reference& reference) {
  return std::any_of(
      reference.candidates.begin(), reference.candidates.end(),
      [&](const Candidate& c) { return same_triangle(hit, c) && close_in_t(hit, c); });
}

bool edge_explains_miss(const Reference& reference) {
  return std::all_of(reference.candidates.begin(), reference.candidates.end(),
                     [](const Candidate& c) { return c.borderline; });
}

bool surface_agrees(const accel::geometry::Hit& hit, const Reference& reference) {
  for (const Candidate& c : reference.candidates) {
    if (!same_triangle(hit, c)) continue;
    const accel::geometry::Vec3d n(hit.normal);
    return std::abs(static_cast<double>(hit.u) - c.u) <= kSurfaceTolerance &&
           std::abs(static_cast<double>(hit.v) - c.v) <= kSurfaceTolerance &&
           length(n - c.normal) <= kSurfaceTolerance;
  }
  return true;
}

std::string describe(std::size_t index, const char* what, const accel::geometry::Ray& ray,
                     const accel::geometry::Hit& hit, const Reference& reference) {
  std::string text = fmt::format(
      "{} at ray {}: o=({}, {}, {}) d=({}, {}, {}) t in [{}, {}]\n  got state {} t {} node {} "
      "primitive {} uv ({}, {}) normal ({}, {}, {})",
      what, index, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
      ray.direction.z, ray.tmin, ray.tmax, static_cast<int>(hit.state), hit.t, hit.node,
      hit.primitive, hit.u, hit.v, hit.normal.x, hit.normal.y, hit.normal.z);
  if (reference.invalid) text += "\n  the ray is invalid";
  if (reference.candidates.empty()) text += "\n  oracle: no candidate";
  for (std::size_t i = 0; i < std::min<std::size_t>(reference.candidates.size(), 4); ++i) {
    const Candidate& c = reference.candidates[i];
    text += fmt::format(
        "\n  oracle: t {} (+- {}) node {} primitive {} uv ({}, {}) normal ({}, {}, {}){}{}", c.t,
        c.t_tolerance, c.node, c.primitive, c.u, c.v, c.normal.x, c.normal.y, c.normal.z,
        c.accepted ? " accepted" : "", c.borderline ? " borderline" : "");
  }
  return text;
}

}  // namespace

Agreement compare(const accel::geometry::Hit& hit, const Reference& reference) {
  if (reference.invalid) {
    const bool marked = hit.state == HitState::kInvalid && hit.node == 0 && std::isnan(hit.t);
    return marked ? Agreement::kEqual : Agreement::kMismatch;
  }
  const Candidate* closest = reference.closest();
  if (is_miss(hit)) {
    if (closest == nullptr) return Agreement::kEqual;
    return edge_explains_miss(reference) ? Agreement::kEdge : Agreement::kMismatch;
  }
  if (hit.state != HitState::kHit) return Agreement::kMismatch;
  if (closest != nullptr && close_in_t(hit, *closest)) {
    if (same_triangle(hit, *closest)) return Agreement::kEqual;
    const bool ties = std::any_of(
        reference.candidates.begin(), reference.candidates.end(), [&](const Candidate& c) {
          return c.accepted && same_triangle(hit, c) && close_in_t(hit, c);
        });
    if (ties) return Agreement::kTie;
  }
  return edge_explains_hit(hit, reference) ? Agreement::kEdge : Agreement::kMismatch;
}

Agreement compare_any(const accel::geometry::Hit& hit, const Reference& reference) {
  if (reference.invalid) {
    return hit.state == HitState::kInvalid ? Agreement::kEqual : Agreement::kMismatch;
  }
  const bool expected = reference.closest() != nullptr;
  if (hit.state == (expected ? HitState::kHit : HitState::kMiss)) return Agreement::kEqual;
  if (hit.state == HitState::kInvalid) return Agreement::kMismatch;
  const bool doubtful = expected ? edge_explains_miss(reference) : !reference.candidates.empty();
  return doubtful ? Agreement::kEdge : Agreement::kMismatch;
}

std::string Comparison::report() const {
  std::string text =
      fmt::format("{} rays, {} hits, {} ties, {} edges, {} mismatches, {} surface errors", rays,
                  hits, ties, edges, mismatches, surface_errors);
  for (const std::string& example : examples) text += "\n" + example;
  return text;
}

Comparison compare(std::span<const accel::geometry::Ray> rays,
                   std::span<const accel::geometry::Hit> hits, const BruteForce& oracle,
                   const CompareOptions& options) {
  Comparison result;
  result.rays = rays.size();
  if (rays.size() != hits.size()) {
    result.mismatches = std::max(rays.size(), hits.size());
    result.examples.push_back(fmt::format("{} answers to {} rays", hits.size(), rays.size()));
    return result;
  }
  const std::vector<Reference> references = oracle.trace(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Reference& reference = references[i];
    const Agreement agreement =
        options.any ? compare_any(hits[i], reference) : compare(hits[i], reference);
    result.hits += hits[i].state == HitState::kHit;
    result.ties += agreement == Agreement::kTie;
    result.edges += agreement == Agreement::kEdge;
    result.mismatches += agreement == Agreement::kMismatch;
    const char* complaint = agreement == Agreement::kMismatch ? "mismatch"
                            : agreement == Agreement::kEdge   ? "edge"
                                                              : nullptr;
    if (options.surface && agreement == Agreement::kEqual && hits[i].state == HitState::kHit &&
        !surface_agrees(hits[i], reference)) {
      ++result.surface_errors;
      complaint = "wrong surface";
    }
    if (complaint != nullptr && result.examples.size() < kExamples) {
      result.examples.push_back(describe(i, complaint, rays[i], hits[i], reference));
    }
  }
  return result;
}

}  // namespace sightline::tests
