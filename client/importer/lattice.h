// Scenes that lie far from the origin of their vertices, brought near it without moving anything.
#pragma once

#include <array>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

/// Vertices lie far if they are this many times their extent (rounded up to a power of two) from
/// zero.
inline constexpr double kFar = 16;

/// Takes one offset from the vertices of all meshes and puts it into the transforms of the nodes
/// that carry them. Returns the offset, zero on every axis where nothing was done.
///
/// The vertices' extent, the largest of the three, is rounded up to a power of two: the lattice's
/// step. On an axis where all vertices lie kFar steps or more on one side of zero, the offset is
/// the multiple of the step next to their middle. Nothing is rounded: what is left of a vertex is a
/// float, and that and the offset add up to what it was; so do the new transforms. As the offset is
/// the same for all meshes, what was equal in two meshes, vertices or whole contents, is equal
/// still, and what was not is not.
///
/// All stays as it was if a node that carries a mesh has children, which would have to be moved
/// back, or if a translation could not hold its sum with the offset without rounding. Vertices that
/// are not finite are left alone.
std::array<double, 3> rebase(ImportedScene& scene);

/// Takes this offset from the vertices, as rebase does. Returns false, and all stays as it was, if
/// it cannot be done, or not without rounding.
bool shift(ImportedScene& scene, const std::array<double, 3>& offset);

}  // namespace sightline::client::importer
