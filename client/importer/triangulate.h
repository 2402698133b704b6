// Cuts polygons into triangles. Internal to the importer.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/importer/animation.h"
#include "client/types.h"

namespace sightline::client::importer {

/// Appends the n - 2 triangles of a polygon with these n >= 3 corners.
void triangulate(const std::vector<Point>& vertices, std::span<const std::uint32_t> corners,
                 std::vector<Face>& faces);

}  // namespace sightline::client::importer
