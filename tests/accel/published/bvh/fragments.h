// Lists of fragments as input for splits.
#pragma once

#include <cmath>
#include <vector>

#include "accel/mesh/face_boxes.h"
#include "accel/published/bvh/center_lists.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline std::vector<accel::kdtree::Reference> face_refs(const TestMesh& mesh) {
  std::vector<accel::kdtree::Reference> refs(mesh.faces.size());
  refs.resize(accel::mesh::face_references(mesh.view(), 0, mesh.faces.size(), refs.data()));
  return refs;
}

/// Sorted lists, and their memory.
struct SortedFragments {
  explicit SortedFragments(const std::vector<accel::kdtree::Reference>& refs)
      : lists(accel::published::bvh::sort_by_centers(refs, stack, counters)) {}

  accel::published::bvh::FragmentStack stack;
  accel::kdtree::BuildCounters counters;
  accel::published::bvh::CenterLists lists;
};

inline bool is_sorted_along(std::span<const accel::published::bvh::Fragment> list,
                            std::size_t axis) {
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (!accel::published::bvh::precedes(list[i - 1], list[i], axis)) return false;
  }
  return true;
}

/// Rotated about x, y and z by the same angle in degrees.
inline TestMesh turned(TestMesh mesh, double degrees) {
  const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  for (const std::size_t axis : {0u, 1u, 2u}) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (accel::geometry::Vec3f& p : mesh.vertices) {
      const auto x = static_cast<double>(p[u]), y = static_cast<double>(p[v]);
      p[u] = static_cast<float>(c * x - s * y);
      p[v] = static_cast<float>(s * x + c * y);
    }
  }
  return mesh;
}

/// n x n beams along each axis, through each other: large triangles that overlap when they are
/// rotated.
inline TestMesh beams(int n) {
  TestMesh mesh;
  for (const std::size_t axis : {0u, 1u, 2u}) {
    for (int i = 0; i < n * n; ++i) {
      accel::geometry::Vec3f lo{}, hi{};
      lo[(axis + 1) % 3] = static_cast<float>(i % n);
      lo[(axis + 2) % 3] = static_cast<float>(i / n);
      hi = lo + accel::geometry::Vec3f{0.25f, 0.25f, 0.25f};
      hi[axis] = static_cast<float>(n);
      mesh.append(box(lo, hi));
    }
  }
  return mesh;
}

}  // namespace sightline::tests
