// Takes meshes to the scene's coordinates, and builds one tree over all their triangles.
#include "accel/mesh/flat_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/mesh/mesh_stats.h"

namespace sightline::accel::mesh {
namespace {

using geometry::Face;
using geometry::Vec3d;
using geometry::Vec3f;
using wide::Matrix;

bool is_set(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

Vec3d at(const Matrix& m, const Vec3d& p) {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

bool is_mirrored(const Matrix& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
             m[2] * (m[4] * m[9] - m[5] * m[8]) <
         0;
}

bool contains(const geometry::Aabb& box, const Vec3f& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(point[axis] >= box.lo[axis] && point[axis] <= box.hi[axis])) return false;
  }
  return true;
}

/// The arrays of all meshes, only needed until the tree is built.
struct Soup {
  std::vector<Vec3f> vertices;
  std::vector<Face> faces;

  /// Writes a mesh, whose first vertex will have this number. Returns how far the vertices of its
  /// triangles were rounded.
  double add(const FlatPart& part, std::uint32_t first_vertex) {
    const geometry::MeshView& mesh = part.placed.mesh;
    double error = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      Vec3f& rounded = vertices[first_vertex + i];
      // No triangle that can be hit has a vertex outside.
      if (!contains(part.bounds, mesh.vertices[i])) {
        rounded.x = rounded.y = rounded.z = std::numeric_limits<float>::quiet_NaN();
        continue;
      }
      const Vec3d exact = at(part.tree_from_local, Vec3d(mesh.vertices[i]));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rounded[axis] = static_cast<float>(exact[axis]);
        error = std::max(error, std::fabs(exact[axis] - static_cast<double>(rounded[axis])));
      }
    }
    const bool mirrored = is_mirrored(part.tree_from_local);
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      Face& face = faces[part.placed.first + i];
      face = mesh.faces[i];
      if (face[0] == geometry::kNoVertex) continue;
      for (std::uint32_t& corner : face) corner += first_vertex;
      // Its front is then where it is in the mesh.
      if (mirrored) std::swap(face[1], face[2]);
    }
    return error;
  }
};

}  // namespace

std::unique_ptr<const FlatTree> FlatTree::make(std::span<FlatPart> parts,
                                               const split::SplitRule& rule,
                                               kdtree::BuildCounters& built,
                                               const std::atomic<bool>* cancelled) {
  // Ids of faces and runs are below the flags in kdtree::Reference::id.
  constexpr std::uint64_t kMost = std::uint64_t{1} << 28;
  auto made = std::make_unique<FlatTree>();
  std::vector<std::uint32_t> first_vertex;
  std::uint64_t vertices = 0, faces = 0;
  double transforms = 0;
  for (FlatPart& part : parts) {
    part.placed.first = static_cast<std::uint32_t>(faces);
    first_vertex.push_back(static_cast<std::uint32_t>(vertices));
    faces += part.placed.mesh.faces.size();
    vertices += part.placed.mesh.vertices.size();
    if (faces > kMost || vertices > kMost) return nullptr;
    transforms = std::max(transforms, part.error);
    made->meshes_.push_back(part.placed);
  }
  Soup soup{std::vector<Vec3f>(vertices), std::vector<Face>(faces)};
  const double rounding = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, parts.size()), 0.0,
      [&](const tbb::blocked_range<std::size_t>& range, double error) {
        for (std::size_t i = range.begin(); i < range.end() && !is_set(cancelled); ++i)
          error = std::max(error, soup.add(parts[i], first_vertex[i]));
        return error;
      },
      [](double a, double b) { return std::max(a, b); });
  if (is_set(cancelled) || !(rounding < static_cast<double>(wide::kLargestSize))) return nullptr;
  const geometry::MeshView all{soup.vertices, soup.faces};
  const MeshStats stats = compute_mesh_stats(all);
  if (stats.finite_triangles == 0) return nullptr;
  made->tree_ = std::make_unique<MeshTree>(all, stats, TreeBuilder{.rule = rule});
  const lazy::LazyTree& tree = *made->tree_->lazy_tree();
  if (!tree.makes_blocks()) return nullptr;
  made->tree_->expand_all(built, cancelled);
  if (!made->tree_->is_complete()) return nullptr;
  made->frame_ = tree.frame();
  made->frame_.error = geometry::round_up((rounding + transforms) * (1 + 0x1p-20));
  made->mesh_of_.reserve(faces);
  for (const wide::PlacedMesh& placed : made->meshes_) {
    made->mesh_of_.insert(made->mesh_of_.end(), placed.mesh.faces.size(),
                          static_cast<std::uint32_t>(&placed - made->meshes_.data()));
  }
  return made;
}

std::uint64_t FlatTree::bytes() const {
  return tree_->bytes() + meshes_.size() * sizeof(wide::PlacedMesh) +
         mesh_of_.size() * sizeof(std::uint32_t);
}

}  // namespace sightline::accel::mesh
