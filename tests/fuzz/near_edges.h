// Many hard cases in parallel.
#pragma once

#include <cstdint>

#include "tests/fuzz/check_case.h"

namespace sightline::tests {

/// Checks hard cases until they include `near` pairs whose ray passes near an edge, rounded up to
/// whole blocks. The same seed gives the same cases for any number of threads of the calling
/// thread's oneTBB arena.
Tally check_near_edges(std::uint64_t near, std::uint64_t seed, const Asking& asking = {});

}  // namespace sightline::tests
