// Checks the answers of rays in a flat tree of a case's triangles.
#pragma once

#include <optional>
#include <string>

#include "tests/fuzz/verdict/verdict_case.h"

namespace sightline::tests {

/// Puts the triangles into a scene twice, in frames that are rotated, sheared, scaled, mirrored and
/// far away, and the rays with them. Answers by a flat tree equal those of rays that enter the
/// instances. Describes what is wrong. Sets whether there was a flat tree: some frames have none.
std::optional<std::string> check_flat(const VerdictCase& asked, bool& is_flat);

}  // namespace sightline::tests
