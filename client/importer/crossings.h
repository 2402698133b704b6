// Whether edges of a polygon cross. Internal to the importer.
#pragma once

#include <span>

#include "client/importer/orientation.h"

namespace sightline::client::importer {

/// Whether two edges of the closed polygon cross each other at one point inside of both, and each
/// of their ends is farther than `least` from the line of the other edge. Edges that touch or
/// overlap do not cross. Stops after many comparisons, and returns false, as for tens of thousands
/// of edges that are near each other all along.
bool has_crossing(std::span<const PlanePoint> polygon, double least);

}  // namespace sightline::client::importer
