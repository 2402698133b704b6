// A mesh's tree by one builder, the hits of rays in it, and the same hits without a tree.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/mesh_query.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// This builder counts its list again for every candidate: its time is quadratic.
inline bool is_quadratic(std::string_view builder) { return builder == "sah-naive"; }

/// A builder by its name, down to leaves of the tree: without leaf blocks.
inline accel::published::AnyBuilder plain_builder(std::string_view name) {
  accel::published::AnyBuilder builder = *accel::published::make_builder(name);
  if (name == "scan-fast" || name == "scan-best") {
    EXPECT_TRUE(accel::published::set_parameter(builder, "blocks", "off"));
  }
  return builder;
}

/// A miss: t is infinite. Compares bit for bit.
struct NearestHit {
  double t = accel::geometry::kInfinity;
  std::uint32_t primitive = 0;
  bool operator==(const NearestHit&) const = default;
};

/// The mesh must outlive it. Rays are valid.
class AskedTree {
 public:
  AskedTree(const TestMesh& mesh, const accel::mesh::TreeBuilder& builder,
            accel::mesh::References references = accel::mesh::References::kRuns)
      : tree_(mesh.view(), accel::mesh::compute_mesh_stats(mesh.view()), builder, references) {}
  AskedTree(const TestMesh& mesh, std::string_view builder)
      : AskedTree(mesh, *accel::published::make_builder(builder)) {}

  void build(const std::atomic<bool>* cancelled = nullptr) { tree_.expand_all(built_, cancelled); }

  NearestHit nearest(const accel::geometry::Ray& ray,
                     accel::lazy::Growth growth = accel::lazy::Growth::kFirstTouch,
                     const std::atomic<bool>* cancelled = nullptr) {
    accel::kdtree::EpochPin pin;
    MeshQuery query = query_of(ray);
    query.cells.pin = &pin;
    query.cells.growth = growth;
    query.cells.cancelled = cancelled;
    ask(tree_, query, walked_, built_);
    return query.found ? NearestHit{query.best_t, query.best_primitive} : NearestHit{};
  }

  accel::kdtree::TreeMetrics metrics() const {
    const accel::kdtree::EpochPin pin;
    return tree_.metrics();
  }
  const accel::kdtree::BuildCounters& built() const { return built_; }
  const accel::kdtree::WalkCounters& walked() const { return walked_; }

 private:
  accel::mesh::MeshTree tree_;
  accel::kdtree::WalkCounters walked_;
  accel::kdtree::BuildCounters built_;
};

/// By the hit rule over every face, without a tree.
inline NearestHit nearest_without_tree(const TestMesh& mesh, const accel::geometry::Ray& ray) {
  const accel::geometry::LocalRay local =
      *accel::geometry::make_local_ray(ray.origin, ray.direction);
  NearestHit best;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (!accel::mesh::face_bounds(mesh.view(), i)) continue;
    const auto& [a, b, c] = mesh.faces[i];
    const auto t =
        accel::geometry::intersect(local, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    if (!t) continue;
    const double world = *t * local.unit;
    if (world >= ray.tmin && world <= ray.tmax && world < best.t) {
      best = {world, static_cast<std::uint32_t>(i)};
    }
  }
  return best;
}

inline std::vector<NearestHit> nearest_without_tree(const TestMesh& mesh,
                                                    std::span<const accel::geometry::Ray> rays) {
  std::vector<NearestHit> hits;
  hits.reserve(rays.size());
  for (const accel::geometry::Ray& ray : rays) hits.push_back(nearest_without_tree(mesh, ray));
  return hits;
}

/// The nearest hits of rays in a mesh's full and growing trees, by these builders, are those that
/// are found without a tree.
inline void expect_right(
    const TestMesh& mesh, const std::vector<accel::geometry::Ray>& rays,
    const std::vector<std::string_view>& builders = accel::published::builder_names()) {
  const std::vector<NearestHit> expected = nearest_without_tree(mesh, rays);
  for (const std::string_view builder : builders) {
    AskedTree full(mesh, builder), growing(mesh, builder);
    full.build();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(full.nearest(rays[i]), expected[i]) << builder << " ray " << i;
      ASSERT_EQ(growing.nearest(rays[i]), expected[i]) << builder << " growing, ray " << i;
    }
  }
}

}  // namespace sightline::tests
