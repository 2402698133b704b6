// Runs of consecutive faces: the references that a mesh's tree starts from if the order of its
// faces is compact. The method is ours; Hunt, Mark, Fussell 2007 start from a given hierarchy.
#pragma once

#include <cstddef>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::mesh {

/// Faces of a run, and of the short runs that it is opened into. Short runs are opened into faces.
inline constexpr std::size_t kRunLength = 16, kShortRunLength = 4;

/// Whether runs are compact and not too few. Reads a sample of the faces. `bounds` are those of the
/// mesh.
bool are_runs_compact(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                      kdtree::BuildCounters& counters);

/// Number of runs of kRunLength faces; the last may be shorter.
inline std::size_t count_runs(const geometry::MeshView& mesh) {
  return (mesh.faces.size() + kRunLength - 1) / kRunLength;
}

/// Writes a reference for every run from `begin` to `end` - 1 that has a finite triangle, and
/// returns their number. `out` has capacity for all runs. The weight of a reference is its number
/// of finite triangles.
std::size_t run_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                           kdtree::Reference* out, kdtree::BuildCounters& counters);

/// Appends the short runs of a run, or the faces of a short run.
void open_run(const geometry::MeshView& mesh, const kdtree::Reference& run,
              std::vector<kdtree::Reference>& out, kdtree::BuildCounters& counters);

struct FaceRange {
  std::size_t begin = 0, end = 0;
};
FaceRange faces_of_run(const geometry::MeshView& mesh, const kdtree::Reference& run);

}  // namespace sightline::accel::mesh
