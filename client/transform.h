// Where a node lies in its parent, and how that is expected to change.
#pragma once

#include <array>
#include <cstdint>

namespace sightline::client {

/// Rows of [linear | translation], parent from local.
using Transform = std::array<double, 12>;
inline constexpr Transform kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// How a node is expected to change.
enum class Mobility : std::uint8_t { kStatic, kRigid, kDeforming };

}  // namespace sightline::client
