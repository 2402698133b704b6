// Rays in float32 that begin too far out for the scene that they are cast into.
#pragma once

#include <array>
#include <string>

#include "client/cast_options.h"

namespace sightline::client::cli::verbs {

/// Origins are coarse if neighbouring float32 values lie farther apart, where the farthest ray
/// begins, than this share of the scene's diagonal.
inline constexpr double kMaxSpacing = 1e-6;

/// The same rays; `reach`, which must outlive the cast, grows to the largest finite |coordinate| of
/// their origins.
RaySource<float> watch_reach(RaySource<float> source, float& reach);

/// What to tell of rays that begin as far out as `reach` in a scene of these bounds (min x y z, max
/// x y z); empty if they are fine.
std::string origin_precision_warning(float reach, const std::array<double, 6>& bounds);

}  // namespace sightline::client::cli::verbs
