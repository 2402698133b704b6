// Compares answers with the oracle's: equal except for ties, or a report of the differences.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/brute_force.h"

namespace sightline::tests {

enum class Agreement : std::uint8_t {
  kEqual,  ///< Same miss or hit, t within the tolerance, same (node, primitive).
  kTie,    ///< Another triangle, which ties with the nearest one within the tolerance.
  kEdge,   ///< Right if a ray this close to an edge, to tmin or to tmax may be decided either way.
  kMismatch,  ///< Wrong.
};

Agreement compare(const accel::geometry::Hit& hit, const Reference& reference);
/// For any-hit answers: only `state`.
Agreement compare_any(const accel::geometry::Hit& hit, const Reference& reference);

struct Comparison {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t ties = 0;
  std::uint64_t edges = 0;
  std::uint64_t mismatches = 0;
  std::uint64_t surface_errors =
      0;  ///< Barycentrics or normal wrong where the triangle is the same.
  std::vector<std::string>
      examples;  ///< The first few mismatches, edges and surface errors, in words.

  bool clean() const { return mismatches == 0 && surface_errors == 0; }
  std::string report() const;
};

struct CompareOptions {
  bool any = false;      ///< The answers are any-hit answers.
  bool surface = false;  ///< Also checks u, v and the normal.
};

/// hits[i] answers rays[i]. The oracle traces the rays in the calling thread's oneTBB arena.
/// Different sizes are a mismatch.
Comparison compare(std::span<const accel::geometry::Ray> rays,
                   std::span<const accel::geometry::Hit> hits, const BruteForce& oracle,
                   const CompareOptions& options = {});

}  // namespace sightline::tests
