// A greatest distance for all points of a file.
#pragma once

#include "client/cli/files/ray_file.h"

namespace sightline::client::cli::files {

/// Makes `most` the greatest distance of every point; where a point has its own, the smaller of
/// both. The points become double: as float, `most` could be another number.
void limit_distances(RayFile& points, double most);

}  // namespace sightline::client::cli::files
