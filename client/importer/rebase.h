// Moves the vertices of a far-away scene near the origin, without moving any triangle.
#pragma once

#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Vertices are far away if their distance from zero is this many times their extent (rounded up to
/// a power of two).
inline constexpr double kFar = 16;

/// What was subtracted from the vertices of each mesh, and what it cost.
struct Rebased {
  std::vector<Point> offsets;
  std::vector<Warning> warnings;
};

/// Subtracts an offset from the vertices of each mesh, adds it to the transforms of the nodes that
/// have the mesh, and leaves vertices that are floats.
///
/// If all vertices are floats, nothing is rounded, and all meshes have one offset: on an axis where
/// all vertices lie kFar steps or more on one side of zero, the multiple of the step nearest to
/// their middle, else 0. The step is the largest extent of the vertices, rounded up to a power of
/// two. So the rest of a vertex is a float, and the rest plus the offset is the old value; the same
/// holds for the transforms.
///
/// Otherwise vertices are rounded as lattice.h says, with the step of the largest mesh. All meshes
/// have one offset if together they are at most a step in size, else each has its own. A mesh for
/// which that step is far too coarse has a step of its own, with a warning. A loss of more than
/// kWarnedLoss of a mesh's size is a warning, too; a smaller one, if floats near the mesh would
/// lose less, is a note.
///
/// Vertices or whole meshes that were equal stay equal, and different ones that are floats stay
/// different. Offsets are 0 if a node that has a mesh has children, because they would have to
/// be moved back, or if a translation cannot hold its sum with the offset without rounding.
/// Vertices that are not finite are not changed.
Rebased rebase(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes);

/// A loss of a larger share of a mesh's size is a warning.
inline constexpr double kWarnedLoss = 1e-4;

/// Does what rebase does, with these offsets; there is one for each mesh. Errors: kInvalidArgument:
/// the rest of a vertex loses more than kWarnedLoss of its mesh's size as a float, or a transform
/// cannot hold its sum.
Result<Rebased> rebase_to(std::vector<Point> offsets, std::vector<FileMesh>& meshes,
                          std::vector<ImportedNode>& nodes);

}  // namespace sightline::client::importer
