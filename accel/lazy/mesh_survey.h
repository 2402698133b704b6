// One pass over a mesh's arrays: are the indices good, where do its triangles lie, and do those lie
// together that follow each other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/mesh_view.h"
#include "accel/lazy/face_boxes.h"
#include "accel/lazy/runs.h"

namespace sightline::accel {

/// What a mesh's tree begins with.
enum class References : std::uint8_t {
  kSoup,  ///< Every triangle on its own, as in the paper.
  kRuns,  ///< Runs of consecutive triangles, where those are compact; opened where rays look.
};

struct MeshSurvey {
  std::uint64_t triangles = 0;         ///< Faces that hold one.
  std::uint64_t finite_triangles = 0;  ///< With finite vertices: what can be hit.
  /// The first face with an index out of range; it and its like count as triangles, never as
  /// finite.
  std::size_t first_bad_face = FaceSum::kNone;
  Aabb bounds;  ///< Of the finite triangles, each widened as widen_flat does.
  Runs runs;    ///< Empty for a soup.
};

/// Parallel in the caller's arena; the result does not depend on it.
MeshSurvey survey_mesh(const MeshView& mesh, References references);

}  // namespace sightline::accel
