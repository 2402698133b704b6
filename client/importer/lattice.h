// Moves the vertices of a far-away scene near the origin, without moving any triangle.
#pragma once

#include <array>
#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

/// Vertices are far away if their distance from zero is this many times their extent (rounded up to
/// a power of two).
inline constexpr double kFar = 16;

/// Subtracts one offset from the vertices of all meshes, and adds it to the transforms of the nodes
/// that carry them. Returns the offset. It is zero on every axis where nothing was done.
///
/// The step of the lattice is the largest extent of the vertices, rounded up to a power of two. On
/// an axis where all vertices lie kFar steps or more on one side of zero, the offset is the
/// multiple of the step nearest to their middle. Nothing is rounded: the rest of a vertex is a
/// float, and the rest plus the offset is the old value; the same holds for the transforms. The
/// offset is the same for all meshes. So vertices or whole meshes that were equal stay equal, and
/// different ones stay different.
///
/// Nothing changes if a node that carries a mesh has children, because they would have to be moved
/// back, or if a translation cannot hold its sum with the offset without rounding. Vertices that
/// are not finite are not changed.
std::array<double, 3> rebase(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes);

/// Subtracts this offset from the vertices, as rebase does. Returns false and changes nothing if
/// the offset cannot be moved into the nodes without rounding.
bool shift(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes,
           const std::array<double, 3>& offset);

}  // namespace sightline::client::importer
