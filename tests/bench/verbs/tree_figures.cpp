// Figures of a snapshot's built trees.
#include "tests/bench/verbs/tree_figures.h"

#include <algorithm>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/bvh/bvh_tree.h"
#include "accel/published/bvh/traverse.h"
#include "accel/published/kd/plain_tree.h"
#include "accel/published/kd/traverse.h"
#include "scenegraph/instances/flat_scene.h"
#include "tests/bench/verbs/end_point_overlap.h"
#include "tests/support/all_instances.h"
#include "tests/support/walk_in_doubles.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::published::bvh::BvhTree;
using accel::published::kd::PlainTree;

namespace {

// Marks what a walk sees.
struct Seen {
  std::vector<bool>& seen;
  double t_out;

  void reference(std::uint32_t face) { seen[face] = true; }
  void deferred(const accel::kdtree::DeferredCell&) {}
  bool leaf(std::span<const std::uint32_t> faces) {
    for (const std::uint32_t face : faces) seen[face] = true;
    return false;
  }
  bool references(std::span<const accel::kdtree::Reference>) { return false; }
  double limit() const { return t_out; }
};

void walk(const accel::kdtree::KdTree& tree, const accel::kdtree::TreeRay& ray,
          accel::kdtree::WalkCounters&, Seen& seen) {
  tests::walk_in_doubles(tree, ray, seen);
}

// Marks the triangles in the leaves that rays enter.
template <class Tree>
class LeafMarker {
 public:
  LeafMarker(const Tree& tree, const accel::geometry::Aabb& bounds, std::vector<bool>& seen)
      : tree_(tree), bounds_(bounds), seen_(seen) {}

  void mark(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax) {
    accel::geometry::LocalRay local;
    accel::kdtree::TreeRay ray;
    if (!accel::geometry::set_local_ray(origin, direction, local) ||
        !accel::kdtree::enter(local, bounds_, tmin / local.unit, tmax / local.unit, ray)) {
      return;
    }
    accel::kdtree::WalkCounters unused;
    Seen visit{seen_, ray.t_out};
    walk(tree_, ray, unused, visit);
  }

 private:
  const Tree& tree_;
  const accel::geometry::Aabb& bounds_;
  std::vector<bool>& seen_;
};

void add(const accel::kdtree::TreeMetrics& m, accel::kdtree::TreeMetrics& sum) {
  sum.nodes += m.nodes;
  sum.leaves += m.leaves;
  sum.nonempty_leaves += m.nonempty_leaves;
  sum.references += m.references;
  sum.max_depth = std::max(sum.max_depth, m.max_depth);
  sum.deferred_cells += m.deferred_cells;
  sum.expected_traversals += m.expected_traversals;
  sum.expected_leaves += m.expected_leaves;
  sum.expected_intersections += m.expected_intersections;
  sum.sah_cost += m.sah_cost;
  sum.overlap += m.overlap;
  sum.bytes += m.bytes;
}

}  // namespace

accel::kdtree::TreeMetrics measure_meshes(const scenegraph::revision::Snapshot& snapshot) {
  const accel::kdtree::EpochPin pin;
  accel::kdtree::TreeMetrics sum;
  const auto flat = snapshot.trees().static_tree().flat();
  if (flat != nullptr) {
    add(flat->triangles().tree().metrics(), sum);
    sum.bytes += flat->bytes() - flat->triangles().tree().bytes();
  }
  for (const scenegraph::model::Mesh* mesh : snapshot.meshes()) {
    if (flat == nullptr || !flat->has(mesh) || !mesh->tree().untouched())
      add(mesh->tree().metrics(), sum);
  }
  return sum;
}

std::optional<double> end_point_overlap(const scenegraph::revision::Snapshot& snapshot) {
  std::optional<double> sum;
  for (const scenegraph::model::Mesh* mesh : snapshot.meshes()) {
    const auto* tree = dynamic_cast<const BvhTree*>(mesh->tree().whole());
    if (tree == nullptr || tree->built() == nullptr) continue;
    sum = sum.value_or(0) + bench::end_point_overlap(*tree->built(), mesh->view());
  }
  return sum;
}

void set_metrics(Row& row, const accel::kdtree::TreeMetrics& metrics) {
  row["nodes"] = metrics.nodes;
  row["leaves"] = metrics.leaves;
  row["nonempty_leaves"] = metrics.nonempty_leaves;
  row["references"] = metrics.references;
  row["max_depth"] = metrics.max_depth;
  row["sah_cost"] = metrics.sah_cost;
  row["expected_traversals"] = metrics.expected_traversals;
  row["expected_leaves"] = metrics.expected_leaves;
  row["expected_intersections"] = metrics.expected_intersections;
  row["overlap"] = metrics.overlap;
  row["bytes_final"] = metrics.bytes;
}

void SeenTriangles::add(std::span<const accel::geometry::Ray> rays,
                        std::span<const accel::geometry::Hit> hits) {
  const accel::kdtree::EpochPin pin;
  for (const scenegraph::instances::Instance& instance :
       tests::all_instances(snapshot_.trees().static_tree())) {
    std::vector<bool>& marks = seen_[instance.mesh];
    marks.resize(instance.mesh->faces());
    const auto mark_all = [&](auto&& marker) {
      for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].state == accel::geometry::HitState::kInvalid ||
            (instance.mask & rays[i].mask) == 0)
          continue;
        marker.mark(instance.local_from_world.point(rays[i].origin),
                    instance.local_from_world.direction(rays[i].direction), rays[i].tmin,
                    std::min(rays[i].tmax, hits[i].t));
      }
    };
    const accel::mesh::MeshTree& tree = instance.mesh->tree();
    if (tree.kd() != nullptr) {
      mark_all(LeafMarker(*tree.kd(), tree.kd()->bounds(), marks));
    } else if (tree.whole()->is_built()) {
      if (const auto* plain = dynamic_cast<const PlainTree*>(tree.whole())) {
        mark_all(LeafMarker(*plain->built(), plain->bounds(), marks));
      } else {
        const auto& bvh = *dynamic_cast<const BvhTree&>(*tree.whole()).built();
        mark_all(LeafMarker(bvh, bvh.root.box, marks));
      }
    }
  }
}

std::uint64_t SeenTriangles::count() const {
  std::uint64_t count = 0;
  for (const auto& [mesh, marks] : seen_) {
    count += static_cast<std::uint64_t>(std::count(marks.begin(), marks.end(), true));
  }
  return count;
}

std::uint64_t visible_triangles(const scenegraph::revision::Snapshot& snapshot,
                                std::span<const accel::geometry::Ray> rays,
                                std::span<const accel::geometry::Hit> hits) {
  SeenTriangles seen(snapshot);
  seen.add(rays, hits);
  return seen.count();
}

}  // namespace sightline::bench
