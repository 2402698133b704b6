// A warning about float32 rays whose origins are too far out for the precision of float32.
#pragma once

#include <array>
#include <string>

#include "client/cast_options.h"
#include "client/cli/files/row_layout.h"

namespace sightline::client::cli::verbs {

/// The largest accepted spacing of float32 values at the farthest origin, as a share of the scene's
/// diagonal.
inline constexpr double kMaxSpacing = 1e-6;

/// Returns a source of the same rays. While it is read, `reach` grows to the largest finite
/// |coordinate| of their origins. `reach` must outlive the cast.
RaySource<float> watch_reach(RaySource<float> source, float& reach);

/// The warning for rays with origins as far out as `reach`, in a scene with these bounds (min x y
/// z, max x y z). Empty if the precision suffices.
std::string origin_precision_warning(float reach, const std::array<double, 6>& bounds,
                                     files::RowKind asked = files::RowKind::kRays);

}  // namespace sightline::client::cli::verbs
