// Checks the float tests, and packets that walk by them, against the hit rule.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/fuzz/verdict/verdict_case.h"

namespace sightline::tests {

struct VerdictTally {
  std::uint64_t packets = 0, pairs = 0, hits = 0;
  std::uint64_t sure_misses = 0, sure_hits = 0;  ///< Pairs that floats decide.
  std::uint64_t groups = 0;                      ///< Groups of several rays.
  std::uint64_t flat = 0;                        ///< Packets that walked a flat tree, too.
};

/// Searches a case for a counterexample to docs/hit_rule.md, section 7, on one SIMD target of
/// the processor: its number, modulo how many there are. Describes the first, or nothing.
std::optional<std::string> check_on_target(std::size_t target, const VerdictCase& asked,
                                           VerdictTally& tally);

/// Checks all of them.
std::optional<std::string> check_on_every_target(const VerdictCase& asked, VerdictTally& tally);

}  // namespace sightline::tests
