// The product's walk with an exchangeable triangle test.
#include "tests/bench/verbs/kernel_walk.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/trace.h"
#include "tests/bench/verbs/plain_float.h"
#include "tests/support/all_instances.h"
#include "tests/support/walk_in_doubles.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::LocalRay;
using accel::geometry::MeshView;
using accel::geometry::Ray;
using accel::kdtree::DeferredCell;
using accel::kdtree::TreeRay;
using scenegraph::instances::Instance;
using scenegraph::instances::Instances;

class Exact {
 public:
  explicit Exact(const LocalRay& ray) : ray_(ray) {}
  std::optional<double> operator()(const accel::geometry::Vec3f& a, const accel::geometry::Vec3f& b,
                                   const accel::geometry::Vec3f& c) const {
    return accel::geometry::intersect(ray_, a, b, c);
  }

 private:
  const LocalRay& ray_;
};

// The best hit so far, by (t, node, primitive). t is in units of the world ray's direction.
class Nearest {
 public:
  explicit Nearest(const Ray& ray) : tmin_(ray.tmin), tmax_(ray.tmax) {
    best_.node = ~std::uint64_t{0};
  }

  double tmin() const { return tmin_; }
  double tmax() const { return std::min(tmax_, best_.t); }

  void offer(double t, std::uint64_t node, std::uint32_t primitive) {
    if (!(t >= tmin_ && t <= tmax_) || t > best_.t) return;
    if (t == best_.t) {
      if (node > best_.node) return;
      if (node == best_.node && primitive >= best_.primitive) return;
    }
    best_.t = t;
    best_.node = node;
    best_.primitive = primitive;
    best_.state = accel::geometry::HitState::kHit;
  }

  Hit hit() const { return best_.state == accel::geometry::HitState::kHit ? best_ : Hit{}; }

 private:
  double tmin_, tmax_;
  Hit best_;
};

// All distinct triangles that the ray meets.
class Crossings {
 public:
  explicit Crossings(const Ray& ray) : tmin_(ray.tmin), tmax_(ray.tmax) {}

  double tmin() const { return tmin_; }
  double tmax() const { return tmax_; }

  void offer(double t, std::uint64_t node, std::uint32_t primitive) {
    if (!(t >= tmin_ && t <= tmax_)) return;
    const std::pair crossing{node, primitive};
    if (std::find(found_.begin(), found_.end(), crossing) == found_.end()) {
      found_.push_back(crossing);
    }
  }

  std::uint32_t count() const { return static_cast<std::uint32_t>(found_.size()); }

 private:
  double tmin_, tmax_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> found_;
};

template <class Test, class Answer>
struct MeshVisit {
  const MeshView& mesh;
  const TreeRay& ray;
  const Test& triangle;
  std::uint64_t node;
  Answer& answer;

  double limit() const { return answer.tmax() / ray.local->unit + ray.slack; }

  void reference(std::uint32_t id) {
    const accel::geometry::Face& f = mesh.faces[id];
    const std::optional<double> local =
        triangle(mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]);
    if (local) answer.offer(*local * ray.local->unit, node, id);
  }

  void deferred(const DeferredCell&) {
    for (std::uint32_t id = 0; id < mesh.faces.size(); ++id) reference(id);
  }
};

template <class Test, class Answer>
struct SceneVisit {
  const Instances& instances;
  const Ray& ray;
  const LocalRay& centered;
  double slack;
  Answer& answer;

  double limit() const { return answer.tmax() / centered.unit + slack; }

  void deferred(const DeferredCell&) {
    for (const Instance& instance : tests::all_instances(instances)) reference(instance.index);
  }

  void reference(std::uint32_t id) {
    const Instance& instance = instances[id];
    if ((instance.mask & ray.mask) == 0) return;
    TreeRay in_box;
    if (!accel::kdtree::enter(centered, instance.box, answer.tmin() / centered.unit,
                              answer.tmax() / centered.unit, in_box)) {
      return;
    }
    const auto local =
        accel::geometry::make_local_ray(instance.local_from_world.point(ray.origin),
                                        instance.local_from_world.direction(ray.direction));
    if (!local) return;
    const accel::kdtree::KdTree& tree = *instance.mesh->tree().kd();
    TreeRay in_mesh;
    if (!accel::kdtree::enter(*local, tree.bounds(), answer.tmin() / local->unit,
                              answer.tmax() / local->unit, in_mesh)) {
      return;
    }
    const MeshView mesh = instance.mesh->view();
    const Test test(*in_mesh.local);
    MeshVisit<Test, Answer> visit{mesh, in_mesh, test, instance.node, answer};
    tests::walk_in_doubles(tree, in_mesh, visit);
  }
};

template <class Test, class Answer>
Answer cast(const Instances& instances, const Ray& ray) {
  Answer answer(ray);
  const auto centered =
      accel::geometry::make_local_ray(ray.origin - instances.center(), ray.direction);
  const accel::kdtree::KdTree& tree = instances.tree().tree();
  TreeRay scene_ray;
  if (!centered || instances.size() == 0 ||
      !accel::kdtree::enter(*centered, tree.bounds(), ray.tmin / centered->unit,
                            ray.tmax / centered->unit, scene_ray)) {
    return answer;
  }
  SceneVisit<Test, Answer> visit{instances, ray, *centered, scene_ray.slack, answer};
  tests::walk_in_doubles(tree, scene_ray, visit);
  return answer;
}

template <class Work>
void in_blocks(std::size_t count, const Work& work) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, scenegraph::kRaysPerBlock),
      [&](const auto& range) {
        const accel::kdtree::EpochPin pin;
        for (std::size_t i = range.begin(); i != range.end(); ++i) work(i);
      },
      tbb::simple_partitioner{});
}

template <class Test>
void trace_closest(const Instances& instances, std::span<const Ray> rays, std::span<Hit> hits) {
  in_blocks(rays.size(),
            [&](std::size_t i) { hits[i] = cast<Test, Nearest>(instances, rays[i]).hit(); });
}

template <class Test>
void count_crossings(const Instances& instances, std::span<const Ray> rays,
                     std::span<std::uint32_t> counts) {
  in_blocks(rays.size(),
            [&](std::size_t i) { counts[i] = cast<Test, Crossings>(instances, rays[i]).count(); });
}

}  // namespace

void trace_closest(const Instances& instances, TriangleTest test, std::span<const Ray> rays,
                   std::span<Hit> hits) {
  test == TriangleTest::kExact ? trace_closest<Exact>(instances, rays, hits)
                               : trace_closest<PlainFloat>(instances, rays, hits);
}

void count_crossings(const Instances& instances, TriangleTest test, std::span<const Ray> rays,
                     std::span<std::uint32_t> counts) {
  test == TriangleTest::kExact ? count_crossings<Exact>(instances, rays, counts)
                               : count_crossings<PlainFloat>(instances, rays, counts);
}

}  // namespace sightline::bench
