// Rays or points of a PLY file.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "client/cli/files/ray_table.h"
#include "client/result.h"

namespace sightline::client::cli::files {

inline constexpr std::string_view kPlyMagic = "ply";

/// A vertex is a ray: x y z and nx ny nz, or ox oy oz and dx dy dz, and tmin tmax if they are
/// there; or a point: x y z, and max if it is there. Text and binary, in both byte orders. The
/// table refers to `file`, unless that is text. Errors: kInvalidArgument, saying what is wrong.
Result<RayTable> parse_ply_rays(std::span<const std::byte> file, RowKind kind = RowKind::kRays);

}  // namespace sightline::client::cli::files
