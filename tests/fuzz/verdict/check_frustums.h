// Checks the answers of frustums through trees of a case's triangles.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "tests/fuzz/verdict/verdict_case.h"
#include "tests/fuzz/verdict/verdict_tree.h"

namespace sightline::tests {

/// From the origins of some rays of a case, or toward those as ends, along all its rays and through
/// its vertices and triangles: nearest and any hit equal the hit rule. Adds the number of rays that
/// frustums answer to `done`. Describes what is wrong.
std::optional<std::string> check_frustums(const VerdictCase& asked, const VerdictTree& tree,
                                          std::uint64_t& done);

}  // namespace sightline::tests
