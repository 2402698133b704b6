// A fast pass over a mesh's arrays, and a slower one over its faces.
#include "accel/mesh/mesh_stats.h"

#include <algorithm>
#include <optional>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/mesh/array_bounds.h"
#include "accel/mesh/face_boxes.h"

namespace sightline::accel::mesh {
namespace {

constexpr std::size_t kPerTask = 65536;
/// Faces in the sample that shows whether the vertices lie where the faces are.
constexpr std::size_t kSampledFaces = 64;
/// The vertices' bounds are used if the sample's bounds have at least this share of their surface.
constexpr double kShareOfSurface = 0.5;

std::uint32_t greatest_index_in_parallel(std::span<const geometry::Face> faces) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, faces.size(), kPerTask), std::uint32_t{0},
      [&](const auto& range, std::uint32_t most) {
        return std::max(most, greatest_index(faces.subspan(range.begin(), range.size())));
      },
      [](std::uint32_t a, std::uint32_t b) { return std::max(a, b); });
}

std::optional<geometry::Aabb> bounds_in_parallel(std::span<const geometry::Vec3f> vertices) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, vertices.size(), kPerTask),
      std::optional<geometry::Aabb>(geometry::Aabb{}),
      [&](const auto& range, std::optional<geometry::Aabb> box) {
        const auto more = bounds_of_vertices(vertices.subspan(range.begin(), range.size()));
        if (!more || !box) return std::optional<geometry::Aabb>();
        box->grow(*more);
        return box;
      },
      [](std::optional<geometry::Aabb> a, const std::optional<geometry::Aabb>& b) {
        if (!a || !b) return std::optional<geometry::Aabb>();
        a->grow(*b);
        return a;
      });
}

/// Computes the result in one pass; returns nothing if the arrays are irregular.
std::optional<MeshStats> stats_of_arrays(const geometry::MeshView& mesh) {
  const std::size_t faces = mesh.faces.size();
  if (faces == 0 || greatest_index_in_parallel(mesh.faces) >= mesh.vertices.size())
    return std::nullopt;
  std::optional<geometry::Aabb> bounds = bounds_in_parallel(mesh.vertices);
  if (!bounds) return std::nullopt;
  const std::size_t stride = std::max<std::size_t>(1, faces / kSampledFaces);
  const geometry::Aabb sampled = bounds_of_faces(mesh, stride);
  if (stride == 1) {
    bounds = sampled;
  } else if (half_area(sampled) < kShareOfSurface * half_area(*bounds)) {
    return std::nullopt;
  }
  return MeshStats{.triangles = faces, .finite_triangles = faces, .bounds = widen_flat(*bounds)};
}

}  // namespace

MeshStats compute_mesh_stats(const geometry::MeshView& mesh) {
  if (const auto stats = stats_of_arrays(mesh)) return *stats;
  const FaceSum all = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.faces.size(), kPerTask), FaceSum{},
      [&](const auto& range, FaceSum sum) {
        constexpr std::size_t kAtOnce = 16;
        for (std::size_t i = range.begin(); i < range.end(); i += kAtOnce)
          sum.add(sum_faces(mesh, i, std::min(i + kAtOnce, range.end())));
        return sum;
      },
      [](FaceSum a, const FaceSum& b) {
        a.add(b);
        return a;
      });
  return {all.triangles, all.finite, all.first_bad, all.box};
}

}  // namespace sightline::accel::mesh
