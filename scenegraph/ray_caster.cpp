// The scene level of a ray's way.
#include "scenegraph/ray_caster.h"

#include <array>
#include <cmath>
#include <limits>

namespace sightline::scenegraph {
namespace {

using accel::AtUnbuilt;
using accel::Hit;
using accel::HitState;
using accel::MeshQuery;
using accel::Ray;

AtUnbuilt at_unbuilt(Growth growth) {
  switch (growth) {
    case Growth::kNone:
      return AtUnbuilt::kSearch;
    case Growth::kBuiltOnly:
      return AtUnbuilt::kSkip;
    case Growth::kFirstTouch:
    case Growth::kFull:
      break;
  }
  return AtUnbuilt::kExpand;
}

/// An instance lies in several cells; the last few entered are not entered again. Forgetting one
/// costs time only.
class RecentlyEntered {
 public:
  bool contains_or_add(std::uint32_t id) {
    for (const std::uint32_t seen : ids_) {
      if (seen == id) return true;
    }
    ids_[next_++ % ids_.size()] = id;
    return false;
  }

 private:
  std::array<std::uint32_t, 8> ids_{~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u};
  std::size_t next_ = 0;
};

}  // namespace

/// What a walk of the scene's tree asks at its leaves and unbuilt cells.
struct RayCaster::Visit {
  RayCaster& caster;
  const Ray& ray;
  const accel::LocalRay& centered;
  double slack;
  MeshQuery& query;
  RecentlyEntered recent;

  double limit() const { return query.best_t / centered.unit + slack; }

  bool leaf(std::span<const std::uint32_t> ids) {
    for (const std::uint32_t id : ids) {
      if (enter(id)) return true;
    }
    return false;
  }

  accel::Unbuilt unbuilt(accel::AtomicSlot& slot, const accel::DeferredCell& cell) {
    if (query.at_unbuilt == AtUnbuilt::kExpand &&
        caster.instances_.tree().expand(slot, caster.built_)) {
      return accel::Unbuilt::kAgain;
    }
    query.met_unbuilt = true;
    if (query.at_unbuilt == AtUnbuilt::kSkip) return accel::Unbuilt::kDone;
    return search(cell) ? accel::Unbuilt::kStop : accel::Unbuilt::kDone;
  }

  bool search(const accel::DeferredCell& cell) {
    if (cell.listed) {
      for (const accel::BoxRef& ref : cell.list.all()) {
        if (enter(ref.id)) return true;
      }
      return false;
    }
    for (std::uint32_t id = 0; id < caster.instances_.list().size(); ++id) {
      if (enter(id)) return true;
    }
    return false;
  }

  /// Whether an instance is entered depends on the ray and its box alone, not on the cell that led
  /// here.
  bool enter(std::uint32_t id) {
    const Instance& instance = caster.instances_.list()[id];
    if ((instance.mask & ray.mask) == 0 || recent.contains_or_add(id)) return false;
    accel::TreeRay in_box;
    const double tmax = std::fmin(query.tmax, query.best_t);
    if (!accel::enter(centered, instance.box, query.tmin / centered.unit, tmax / centered.unit,
                      in_box))
      return false;
    caster.enter_instance(ray, id, query);
    return query.any && query.found;
  }
};

RayCaster::RayCaster(const Instances& instances, const TraceOptions& options)
    : instances_(instances), options_(options), at_unbuilt_(at_unbuilt(options.growth)) {}

Hit RayCaster::cast(const Ray& ray) {
  ++stats_.rays;
  const std::uint64_t work_before = walked_.steps + walked_.tests;
  const std::optional<accel::LocalRay> centered =
      accel::make_local_ray(ray.origin - instances_.center(), ray.direction);
  if (!centered || std::isnan(ray.tmin) || std::isnan(ray.tmax)) {
    ++stats_.invalid;
    Hit invalid;
    invalid.t = std::numeric_limits<double>::quiet_NaN();
    invalid.state = HitState::kInvalid;
    return invalid;
  }
  MeshQuery query;
  query.tmin = ray.tmin;
  query.tmax = ray.tmax;
  query.at_unbuilt = at_unbuilt_;
  query.any = options_.kind == QueryKind::kAny;
  accel::TreeRay scene_ray;
  accel::LazyTree& tree = instances_.tree();
  if (!instances_.list().empty() &&
      accel::enter(*centered, tree.tree().bounds(), ray.tmin / centered->unit,
                   ray.tmax / centered->unit, scene_ray)) {
    Visit visit{*this, ray, *centered, scene_ray.slack, query, {}};
    accel::walk(tree.tree(), scene_ray, tree.root(), walked_, visit);
  }
  Hit hit;
  if (query.found) {
    ++stats_.hits;
    hit = surface(ray, query);
  }
  const std::uint64_t work = walked_.steps + walked_.tests - work_before;
  hit.work = static_cast<std::uint32_t>(std::min<std::uint64_t>(work, accel::kWorkUnbuilt - 1)) |
             (query.met_unbuilt ? accel::kWorkUnbuilt : 0);
  return hit;
}

void RayCaster::enter_instance(const Ray& ray, std::uint32_t index, MeshQuery& query) {
  const Instance& instance = instances_.list()[index];
  const std::optional<accel::LocalRay> local =
      accel::make_local_ray(instance.local_from_world.point(ray.origin),
                            instance.local_from_world.direction(ray.direction));
  if (!local) return;
  ++stats_.instances_entered;
  if (query.at_unbuilt != AtUnbuilt::kSkip && !instance.entered->load(std::memory_order_relaxed)) {
    instance.entered->store(true, std::memory_order_relaxed);
  }
  const std::uint64_t node_before = query.best_node;
  const std::uint32_t primitive_before = query.best_primitive;
  const double t_before = query.best_t;
  query.ray = *local;
  query.node = instance.node;
  instance.mesh->tree().query(query, walked_, built_);
  if (query.best_t != t_before || query.best_node != node_before ||
      query.best_primitive != primitive_before) {
    nearest_ = index;
  }
}

Hit RayCaster::surface(const Ray& ray, const MeshQuery& query) const {
  Hit hit;
  hit.state = HitState::kHit;
  hit.t = query.best_t;
  hit.node = query.best_node;
  hit.primitive = query.best_primitive;
  if (query.any || !options_.surface) return hit;
  const Instance& instance = instances_.list()[nearest_];
  const accel::MeshView mesh = instance.mesh->view();
  const accel::Face& f = mesh.faces[query.best_primitive];
  const accel::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
  const std::optional<accel::LocalRay> local =
      accel::make_local_ray(instance.local_from_world.point(ray.origin),
                            instance.local_from_world.direction(ray.direction));
  const accel::Barycentric weights =
      accel::barycentric(*local, query.best_t / local->unit, a, b, c);
  hit.u = static_cast<float>(weights.u);
  hit.v = static_cast<float>(weights.v);
  // The inverse transpose keeps the normal on its side of the surface; the winding changes sides
  // where space is mirrored.
  const Vec3d normal =
      instance.local_from_world.transposed(cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a)));
  const double size = instance.mirrored ? -length(normal) : length(normal);
  if (size != 0 && std::isfinite(size)) hit.normal = accel::Vec3f(normal * (1 / size));
  return hit;
}

TraceStats RayCaster::stats() const {
  TraceStats stats = stats_;
  stats.traversal_steps = walked_.steps;
  stats.triangle_tests = walked_.tests;
  stats.cells_expanded = built_.cells_expanded;
  stats.touches = built_.touches;
  stats.touches_prepare = built_.touches_prepare;
  stats.build_seconds = built_.seconds;
  return stats;
}

}  // namespace sightline::scenegraph
