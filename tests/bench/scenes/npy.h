// Writes rays as NumPy's .npy files.
#pragma once

#include <filesystem>
#include <span>

#include "accel/geometry/ray.h"
#include "proto/result.h"

namespace sightline::bench {

/// (n, 8) float64, C order: ox oy oz dx dy dz tmin tmax. Errors: kUnavailable: the file cannot be
/// written completely.
Status write_rays(const std::filesystem::path& file, std::span<const accel::geometry::Ray> rays);

}  // namespace sightline::bench
