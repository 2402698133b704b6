// Figures of a snapshot's built trees.
#include "tests/bench/verbs/tree_figures.h"

#include <algorithm>
#include <limits>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/bvh/bvh_tree.h"
#include "accel/published/bvh/traverse.h"
#include "accel/published/kd/plain_tree.h"
#include "accel/published/kd/traverse.h"
#include "tests/bench/verbs/end_point_overlap.h"
#include "tests/support/all_instances.h"
#include "tests/support/walk_in_doubles.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using accel::published::bvh::BvhTree;
using accel::published::kd::PlainTree;

namespace {

// Walks the cells that one ray's segment passes through, closed, and marks the triangles in leaves.
class LeafMarker {
 public:
  LeafMarker(const accel::kdtree::KdTree& tree, std::vector<bool>& seen)
      : tree_(tree), seen_(seen) {}

  void mark(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax) {
    origin_ = origin;
    direction_ = direction;
    clip(tree_.bounds(), tmin, tmax);
    if (tmin <= tmax) descend(accel::kdtree::load(tree_.root()), tmin, tmax);
  }

 private:
  // Shortens a segment of the ray to its part in a box; tmin > tmax: there is none.
  void clip(const accel::geometry::Aabb& box, double& tmin, double& tmax) const {
    for (std::size_t a = 0; a < 3; ++a) {
      const double lo = static_cast<double>(box.lo[a]) - origin_[a],
                   hi = static_cast<double>(box.hi[a]) - origin_[a];
      if (direction_[a] == 0) {
        if (lo > 0 || hi < 0) tmax = -std::numeric_limits<double>::infinity();
        continue;
      }
      const double at_lo = lo / direction_[a], at_hi = hi / direction_[a];
      tmin = std::max(tmin, std::min(at_lo, at_hi));
      tmax = std::min(tmax, std::max(at_lo, at_hi));
    }
  }

  void descend(accel::wide::Child at, const Vec3f& center, double enter, double leave) {
    if (at.is_block()) {
      const accel::blocks::Block block(at.block());
      for (std::size_t i = 0; i < block.triangles; ++i) seen_[block.id(i)] = true;
      return;
    }
    const accel::wide::WideNode& node = *at.node();
    for (std::size_t i = 0; i < accel::wide::kWidth && node.children[i]; ++i) {
      const accel::geometry::Aabb box = tests::box_of(node, i, center);
      double from = enter, to = leave;
      clip(box, from, to);
      if (from <= to) descend(node.children[i], center, enter, leave);
    }
  }

  void descend(accel::kdtree::Slot slot, double enter, double leave) {
    if (slot.is_leaf()) {
      std::uint32_t storage = 0;
      for (const std::uint32_t face : tree_.leaf(slot, storage)) seen_[face] = true;
      return;
    }
    if (slot.is_finished()) {
      const auto& tree = static_cast<const accel::wide::WideTree&>(*slot.finished());
      return descend(tree.root(), tree.center(), enter, leave);
    }
    if (!slot.is_binary()) return;
    const auto axis = static_cast<std::size_t>(slot.axis());
    const double o = origin_[axis], d = direction_[axis];
    const double plane = static_cast<double>(slot.position());
    const accel::kdtree::AtomicSlot* children = tree_.children(slot);
    if (d == 0) {
      if (o <= plane) descend(accel::kdtree::load(children[0]), enter, leave);
      if (o >= plane) descend(accel::kdtree::load(children[1]), enter, leave);
      return;
    }
    const double t = (plane - o) / d;
    const std::size_t near = d > 0 ? 0 : 1;
    if (enter <= t) descend(accel::kdtree::load(children[near]), enter, std::min(leave, t));
    if (leave >= t) descend(accel::kdtree::load(children[1 - near]), std::max(enter, t), leave);
  }

  const accel::kdtree::KdTree& tree_;
  std::vector<bool>& seen_;
  Vec3d origin_, direction_;
};

// The same for a tree that is built whole, as its own walk enters leaves.
template <class Tree>
class WholeLeafMarker {
 public:
  WholeLeafMarker(const Tree& tree, const accel::geometry::Aabb& bounds, std::vector<bool>& seen)
      : tree_(tree), bounds_(bounds), seen_(seen) {}

  void mark(const Vec3d& origin, const Vec3d& direction, double tmin, double tmax) {
    accel::geometry::LocalRay local;
    accel::kdtree::TreeRay ray;
    if (!accel::geometry::set_local_ray(origin, direction, local) ||
        !accel::kdtree::enter(local, bounds_, tmin / local.unit, tmax / local.unit, ray)) {
      return;
    }
    accel::kdtree::WalkCounters unused;
    Visit visit{seen_, ray.t_out};
    walk(tree_, ray, unused, visit);
  }

 private:
  struct Visit {
    std::vector<bool>& seen;
    double t_out;
    bool leaf(std::span<const std::uint32_t> faces) {
      for (const std::uint32_t face : faces) seen[face] = true;
      return false;
    }
    bool references(std::span<const accel::kdtree::Reference>) { return false; }
    double limit() const { return t_out; }
  };
  const Tree& tree_;
  const accel::geometry::Aabb& bounds_;
  std::vector<bool>& seen_;
};

}  // namespace

accel::kdtree::TreeMetrics measure_meshes(const scenegraph::revision::Snapshot& snapshot) {
  const accel::kdtree::EpochPin pin;
  accel::kdtree::TreeMetrics sum;
  for (const scenegraph::model::Mesh* mesh : snapshot.meshes()) {
    const accel::kdtree::TreeMetrics m = mesh->tree().metrics();
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
      mark_all(LeafMarker(*tree.kd(), marks));
    } else if (tree.whole()->is_built()) {
      if (const auto* plain = dynamic_cast<const PlainTree*>(tree.whole())) {
        mark_all(WholeLeafMarker(*plain->built(), plain->bounds(), marks));
      } else {
        const auto& bvh = *dynamic_cast<const BvhTree&>(*tree.whole()).built();
        mark_all(WholeLeafMarker(bvh, bvh.root.box, marks));
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
