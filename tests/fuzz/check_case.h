// Checks the intersector against the exact reference on one ray and its patch of triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/fuzz/hard_case.h"

namespace sightline::tests {

/// Counts pairs of a ray and a triangle. Only `wrong_*` are errors.
struct PairCount {
  std::uint64_t pairs = 0;
  std::uint64_t near = 0;  ///< The ray passes within 1e-6 of an edge, relative to the triangle.
  std::uint64_t hits = 0;
  std::uint64_t zeros = 0;   ///< At least one of the three determinants is exactly zero.
  std::uint64_t one = 0;     ///< Patches that must be hit exactly once.
  std::uint64_t folded = 0;  ///< Patches that must be hit twice or not at all.

  std::uint64_t wrong_hits = 0;
  std::uint64_t wrong_misses = 0;   ///< Hits that the prefilter rejects.
  std::uint64_t wrong_t = 0;        ///< Beyond kHitError.
  std::uint64_t wrong_weights = 0;  ///< Below 0, with a sum above 1, or of another point.
  std::uint64_t wrong_facing = 0;
  std::uint64_t wrong_sums = 0;

  void add(const PairCount& other);
  std::uint64_t wrong() const {
    return wrong_hits + wrong_misses + wrong_t + wrong_weights + wrong_facing + wrong_sums;
  }
};

struct Tally {
  std::array<PairCount, kPatches> by_patch;
  // In units of the largest |v - o|; see kHitError and barycentric.
  double largest_t_error = 0, largest_point_error = 0;
  std::vector<std::string> findings;  ///< The first few, with all numbers in hexadecimal.

  void add(const Tally& other);
  PairCount total() const;
};

/// How the intersector is called.
struct Asking {
  bool all_orders = false;  ///< All orders of each triangle's vertices.
  bool flush_denormals =
      false;  ///< With results that are denormal flushed to zero, if the machine can.
};

/// Rays that make_local_ray refuses are skipped.
void check(const HardCase& hard, const Asking& asking, Tally& tally);

}  // namespace sightline::tests
