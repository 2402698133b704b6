// The one pass over a mesh.
#include "accel/lazy/mesh_survey.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel {
namespace {

constexpr std::size_t kRunsPerTask = 1024;
/// Fewer are opened as soon as they are looked at.
constexpr std::size_t kFewestRuns = 64;

}  // namespace

MeshSurvey survey_mesh(const MeshView& mesh, References references) {
  const std::size_t faces = mesh.faces.size();
  const std::size_t runs = (faces + Runs::kRunLength - 1) / Runs::kRunLength;
  std::vector<BoxRef> first(references == References::kRuns && runs > kFewestRuns ? runs : 0);
  const FaceSum all = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, runs, kRunsPerTask), FaceSum{},
      [&](const auto& range, FaceSum sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const std::size_t begin = i * Runs::kRunLength;
          const FaceSum run = sum_faces(mesh, begin, std::min(begin + Runs::kRunLength, faces));
          if (!first.empty())
            first[i] = {run.box.lo, 0, run.box.hi, static_cast<std::uint32_t>(run.finite)};
          sum.add(run);
        }
        return sum;
      },
      [](FaceSum a, const FaceSum& b) {
        a.add(b);
        return a;
      });
  MeshSurvey survey{all.triangles, all.finite, all.first_bad, all.box, {}};
  if (!first.empty() && all.finite > 0) survey.runs = Runs(std::move(first), all.box);
  return survey;
}

}  // namespace sightline::accel
