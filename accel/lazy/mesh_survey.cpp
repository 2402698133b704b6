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

bool holds_triangle(const Face& f) {
  return !(f[0] == kNoVertex && f[1] == kNoVertex && f[2] == kNoVertex);
}

bool in_range(const Face& f, std::size_t vertices) {
  return f[0] < vertices && f[1] < vertices && f[2] < vertices;
}

/// What a few faces add up to.
struct Sum {
  std::uint64_t triangles = 0, finite = 0;
  std::size_t first_bad = std::numeric_limits<std::size_t>::max();
  Aabb box;

  void add(const Sum& o) {
    triangles += o.triangles;
    finite += o.finite;
    first_bad = std::min(first_bad, o.first_bad);
    box.grow(o.box);
  }
};

Sum sum_run(const MeshView& mesh, std::size_t begin, std::size_t end) {
  Sum sum;
  for (std::size_t i = begin; i < end; ++i) {
    const Face& f = mesh.faces[i];
    if (!holds_triangle(f)) continue;
    ++sum.triangles;
    if (!in_range(f, mesh.vertices.size())) {
      sum.first_bad = std::min(sum.first_bad, i);
      continue;
    }
    const std::optional<Aabb> box = face_bounds(mesh, i);
    if (!box) continue;
    ++sum.finite;
    sum.box.grow(*box);
  }
  return sum;
}

}  // namespace

MeshSurvey survey_mesh(const MeshView& mesh, References references) {
  const std::size_t faces = mesh.faces.size();
  const std::size_t runs = (faces + Runs::kRunLength - 1) / Runs::kRunLength;
  std::vector<BoxRef> first(references == References::kRuns && runs > kFewestRuns ? runs : 0);
  const Sum all = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, runs, kRunsPerTask), Sum{},
      [&](const auto& range, Sum sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const std::size_t begin = i * Runs::kRunLength;
          const Sum run = sum_run(mesh, begin, std::min(begin + Runs::kRunLength, faces));
          if (!first.empty())
            first[i] = {run.box.lo, 0, run.box.hi, static_cast<std::uint32_t>(run.finite)};
          sum.add(run);
        }
        return sum;
      },
      [](Sum a, const Sum& b) {
        a.add(b);
        return a;
      });
  MeshSurvey survey{all.triangles, all.finite, all.first_bad, all.box, {}};
  if (!first.empty() && all.finite > 0) survey.runs = Runs(std::move(first), all.box);
  return survey;
}

std::optional<Aabb> face_bounds(const MeshView& mesh, std::size_t face) {
  const Face& f = mesh.faces[face];
  if (f[0] == kNoVertex) return std::nullopt;
  Aabb box;
  for (const std::uint32_t v : f) {
    const Vec3f& p = mesh.vertices[v];
    if (!is_finite(p)) return std::nullopt;
    box.grow(p);
  }
  return widen_flat(box);
}

}  // namespace sightline::accel
