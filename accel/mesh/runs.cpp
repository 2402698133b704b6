// Runs of faces, and the test whether they are compact.
#include "accel/mesh/runs.h"

#include <algorithm>

#include "accel/mesh/face_boxes.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::mesh {
namespace {

/// With fewer runs, the root would open them at once.
constexpr std::size_t kFewestRuns = 64;
/// Number of runs in the sample that is measured.
constexpr std::size_t kSampled = 256;
/// Largest mean extent of compact runs, as a share of the mesh's extent. A plane cuts about this
/// share of the runs.
constexpr double kCompact = 1.0 / 5;

/// Flag in the id of a short run, with kdtree::kOpenable and the index of the run.
constexpr std::uint32_t kShort = std::uint32_t{1} << 30;

FaceRange faces_at(const geometry::MeshView& mesh, std::size_t index, std::size_t length) {
  return {index * length, std::min((index + 1) * length, mesh.faces.size())};
}

/// Writes the reference of a run if it has a finite triangle; returns the number of references, 0
/// or 1.
std::size_t run_reference(const geometry::MeshView& mesh, FaceRange faces, std::uint32_t id,
                          kdtree::Reference* out) {
  const FaceSum sum = sum_faces(mesh, faces.begin, faces.end);
  if (sum.finite == 0) return 0;
  *out = {sum.box.lo, kdtree::kOpenable | id, sum.box.hi, static_cast<std::uint32_t>(sum.finite)};
  return 1;
}

}  // namespace

bool are_runs_compact(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                      kdtree::BuildCounters& counters) {
  const std::size_t runs = count_runs(mesh);
  if (runs < kFewestRuns) return false;
  const auto axis = static_cast<std::size_t>(split::longest_axis(bounds));
  const std::size_t stride = std::max<std::size_t>(1, runs / kSampled);
  double sum = 0;
  std::size_t sampled = 0;
  for (std::size_t i = 0; i < runs; i += stride) {
    kdtree::Reference run;
    if (run_references(mesh, i, i + 1, &run, counters) == 0) continue;
    sum += static_cast<double>(run.hi[axis]) - static_cast<double>(run.lo[axis]);
    ++sampled;
  }
  const double whole = static_cast<double>(bounds.hi[axis]) - static_cast<double>(bounds.lo[axis]);
  return sampled > 0 && sum <= kCompact * whole * static_cast<double>(sampled);
}

std::size_t run_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                           kdtree::Reference* out, kdtree::BuildCounters& counters) {
  std::size_t n = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const FaceRange faces = faces_at(mesh, i, kRunLength);
    counters.touches_prepare += faces.end - faces.begin;
    n += run_reference(mesh, faces, static_cast<std::uint32_t>(i), out + n);
  }
  return n;
}

void open_run(const geometry::MeshView& mesh, const kdtree::Reference& run,
              std::vector<kdtree::Reference>& out, kdtree::BuildCounters& counters) {
  const FaceRange faces = faces_of_run(mesh, run);
  counters.touches_prepare += faces.end - faces.begin;
  const std::size_t before = out.size();
  out.resize(before + kRunLength);
  std::size_t end = before;
  if ((run.id & kShort) != 0) {
    end += face_references(mesh, faces.begin, faces.end, &out[end]);
  } else {
    for (std::size_t i = faces.begin; i < faces.end; i += kShortRunLength) {
      const auto index = static_cast<std::uint32_t>(i / kShortRunLength);
      end += run_reference(mesh, faces_at(mesh, index, kShortRunLength), kShort | index, &out[end]);
    }
  }
  out.resize(end);
}

FaceRange faces_of_run(const geometry::MeshView& mesh, const kdtree::Reference& run) {
  const std::uint32_t index = run.id & ~(kdtree::kOpenable | kShort);
  return faces_at(mesh, index, (run.id & kShort) != 0 ? kShortRunLength : kRunLength);
}

}  // namespace sightline::accel::mesh
