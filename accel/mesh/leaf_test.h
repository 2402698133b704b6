// The test of leaves, the same for all trees of meshes: the hit rule, the limits of the query, and
// the choice between hits.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/intersect.h"
#include "accel/geometry/triangle_prefilter.h"
#include "accel/geometry/vertex_sides.h"
#include "accel/kdtree/box_filter.h"
#include "accel/kdtree/traverse.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/mesh/runs.h"
#include "accel/wide/walk_in_doubles.h"

namespace sightline::accel::mesh {

/// For one ray in one tree.
struct LeafTest {
  /// From this many triangles on, testing all with the prefilter takes less time than one by one.
  static constexpr std::size_t kFilterFrom = 4;

  const geometry::MeshView& mesh;
  MeshQuery& query;
  const kdtree::TreeRay& ray;
  kdtree::WalkCounters& walked;
  std::optional<geometry::ShearedRay>
      sheared_ray{};  ///< query.ray, sheared at the first leaf that is long enough.
  std::optional<kdtree::FilterRay> filter_ray{};  ///< `ray`, since the first list.

  double limit() const { return query.best_t / query.ray.unit + ray.slack; }

  bool test(std::uint32_t id) {
    ++walked.tests;
    const geometry::Face& f = mesh.faces[id];
    return decide(id, mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]);
  }

  /// As test() with the corners of the triangle, and without counting it.
  bool decide(std::uint32_t id, const geometry::Vec3f& a, const geometry::Vec3f& b,
              const geometry::Vec3f& c) {
    const std::optional<double> local = intersect(query.ray, a, b, c);
    if (!local) return false;
    const double t = *local * query.ray.unit;
    if (!(t >= query.tmin && t <= query.tmax) || t > query.best_t) return false;
    if (is_culled(query.culling, query.ray, a, b, c)) return false;
    if (query.collects()) {
      collect(t, id);
      return false;
    }
    if (t == query.best_t) {
      if (query.node > query.best_node) return false;
      if (query.node == query.best_node && id >= query.best_primitive) return false;
    }
    query.best_t = t;
    query.best_node = query.node;
    query.best_primitive = id;
    query.best_instance = query.instance;
    query.found = true;
    return query.any;
  }

  void collect(double t, std::uint32_t id) {
    query.found = true;
    if (query.primitives != nullptr) {
      query.primitives->add(id);
    } else if (query.list->add({t, query.node, id, query.instance})) {
      if (const ListedHit* last = query.list->greatest()) query.best_t = last->t;
    }
  }

  bool leaf(std::span<const std::uint32_t> ids) {
    if (ids.size() >= kFilterFrom) return long_leaf(ids);
    for (const std::uint32_t id : ids) {
      if (test(id)) return true;
    }
    return false;
  }

  /// Tests all with the prefilter, then the candidates one by one.
  bool long_leaf(std::span<const std::uint32_t> ids) {
    if (!sheared_ray) sheared_ray = sheared(query.ray);
    while (!ids.empty()) {
      const auto batch = ids.first(std::min(ids.size(), geometry::kPrefilterBatch));
      ids = ids.subspan(batch.size());
      std::uint64_t possible = candidate_mask(mesh, *sheared_ray, batch);
      walked.tests += batch.size() - static_cast<std::size_t>(std::popcount(possible));
      for (; possible != 0; possible &= possible - 1) {
        if (test(batch[static_cast<std::size_t>(std::countr_zero(possible))])) return true;
      }
      if (!ids.empty() && query.is_cancelled()) return true;
    }
    return false;
  }

  /// All blocks of a finished subtree that the ray meets.
  bool finished(const kdtree::FinishedSubtree& subtree) {
    const auto& tree = static_cast<const wide::WideTree&>(subtree);
    return wide::walk_in_doubles(tree, ray, *this, walked);
  }

  /// Tests the references of a part of a list that is searched. Returns true if the traversal ends.
  bool references(std::span<const kdtree::Reference> refs) {
    if (!filter_ray) filter_ray = kdtree::filter_ray(ray);
    while (!refs.empty()) {
      const auto batch = refs.first(std::min(refs.size(), kdtree::kFilterBatch));
      refs = refs.subspan(batch.size());
      kdtree::end_at(*filter_ray, limit());
      if (search(batch, kdtree::may_meet_mask(*filter_ray, batch))) return true;
    }
    return false;
  }

  /// Those of a batch that have a bit in `met`.
  bool search(std::span<const kdtree::Reference> batch, std::uint64_t met) {
    std::array<std::uint32_t, kdtree::kFilterBatch> ids;
    std::size_t count = 0;
    for (; met != 0; met &= met - 1) {
      const kdtree::Reference& ref = batch[static_cast<std::size_t>(std::countr_zero(met))];
      if (!ref.openable()) {
        ids[count++] = ref.id;
      } else if (search_faces(faces_of_run(mesh, ref))) {
        return true;
      }
    }
    return count > 0 && leaf({ids.data(), count});
  }

  /// Tests every face, before there is a tree or a list. Returns true if the traversal ends.
  bool everything() {
    const auto all = static_cast<std::uint32_t>(mesh.faces.size());
    if (!mesh.all_finite) return search_one_by_one({0, all});
    if (!sheared_ray) sheared_ray = sheared(query.ray);
    std::vector<std::uint8_t> sides(mesh.vertices.size());
    geometry::vertex_sides(*sheared_ray, mesh.vertices, sides.data());
    std::array<std::uint32_t, lazy::kSearchStep> ids;
    for (std::uint32_t i = 0; i < all; i += ids.size()) {
      const std::uint32_t end = std::min<std::uint32_t>(i + ids.size(), all);
      const std::size_t met = geometry::faces_at_ray(mesh.faces, i, end, sides.data(), ids.data());
      walked.tests += end - i - met;
      if (leaf({ids.data(), met}) || query.is_cancelled()) return true;
    }
    return false;
  }

  /// The faces of a run.
  bool search_faces(FaceRange faces) {
    if (!mesh.all_finite) return search_one_by_one(faces);
    std::array<std::uint32_t, kRunLength> ids;
    const auto count = faces.end - faces.begin;
    std::iota(ids.begin(), ids.end(), static_cast<std::uint32_t>(faces.begin));
    return leaf({ids.data(), count});
  }

  /// Faces that may be no triangles.
  bool search_one_by_one(FaceRange faces) {
    for (std::size_t i = faces.begin; i < faces.end; ++i) {
      if ((i - faces.begin) % lazy::kSearchStep == lazy::kSearchStep - 1 && query.is_cancelled())
        return true;
      const std::optional<geometry::Aabb> box = face_bounds(mesh, i);
      if (box && may_meet(ray, *box, limit()) && test(static_cast<std::uint32_t>(i))) return true;
    }
    return false;
  }
};

}  // namespace sightline::accel::mesh
