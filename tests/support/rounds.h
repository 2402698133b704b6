// How much of a long test is run. Builds with sanitizers are several times slower, and find faults
// of memory and undefined behaviour in the first rounds; a Release build runs every one.
#pragma once

#include <cstddef>

namespace sightline::tests {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How many of `all` rounds, rays or points: a quarter of them with sanitizers, rounded up.
constexpr std::size_t rounds(std::size_t all) { return kSanitized ? (all + 3) / 4 : all; }

}  // namespace sightline::tests
