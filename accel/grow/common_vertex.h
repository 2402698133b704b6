// Triangles that meet in a vertex: however a cell is cut there, one side keeps them all, and the
// other has a share of them again.
#pragma once

#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::grow {

/// Whether a cut parts so little: of `before` references all but a few are on one side still, and
/// many on the other.
bool one_side_keeps_all(std::size_t before, std::size_t left, std::size_t right);

/// Whether most of a list's faces, which cannot be opened, have a vertex in common, by position.
/// One face is taken for one of them, and compared with some of the others.
bool meet_in_a_vertex(const geometry::MeshView& mesh, std::span<const kdtree::Reference> faces);

/// What is left of the path's budget to a cell of so many faces that meet in a vertex.
kdtree::CellPath capped_budget(const kdtree::CellPath& path, std::size_t references);

}  // namespace sightline::accel::grow
