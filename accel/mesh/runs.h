// Runs of consecutive faces: the references that a mesh's tree begins with where the order of its
// faces is compact. Ours; Hunt, Mark, Fussell 2007 begin with a given hierarchy likewise.
#pragma once

#include <cstddef>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::mesh {

/// Faces of a run, and of the shorter ones that it is opened into; those are opened into faces.
inline constexpr std::size_t kRunLength = 16, kShortRunLength = 4;

/// Whether runs lie together well enough to begin with, and are not too few. Looks at some of the
/// faces. `bounds`: of the mesh.
bool are_runs_compact(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                      kdtree::BuildCounters& counters);

/// Of kRunLength, the last one shorter.
inline std::size_t count_runs(const geometry::MeshView& mesh) {
  return (mesh.faces.size() + kRunLength - 1) / kRunLength;
}

/// Writes a reference for every run from `begin` to `end` that has a triangle to be hit; there is
/// room for all. Returns how many. A reference's weight counts triangles.
std::size_t run_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                           kdtree::Reference* out, kdtree::BuildCounters& counters);

/// Appends what a run stands for: shorter runs, or faces.
void open_run(const geometry::MeshView& mesh, const kdtree::Reference& run,
              std::vector<kdtree::Reference>& out, kdtree::BuildCounters& counters);

struct FaceRange {
  std::size_t begin = 0, end = 0;
};
FaceRange faces_of_run(const geometry::MeshView& mesh, const kdtree::Reference& run);

}  // namespace sightline::accel::mesh
